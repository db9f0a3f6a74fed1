// How bodies of mesh files are drawn: their materials, and what becomes of pictures that cannot be read.
#include "tools/setup/body_look.h"

#include <algorithm>

#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/jpeg_file.h"
#include "tests/support/temporary_folder.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;
using umax::test::contains;

namespace {

const std::vector<unsigned char> red{255, 0, 0}, blue{0, 0, 255};

/// A tetrahedron with texture coordinates, a material for each pair of faces.
const char* const tetrahedron = R"(mtllib paint.mtl
v 0 0 0
v 0.3 0 0
v 0 0.4 0
v 0 0 0.5
vt 0.1 0.1
vt 0.9 0.1
vt 0.1 0.9
usemtl one
f 1/1 2/2 4/3
f 1/1 4/2 3/3
usemtl two
f 2/1 3/2 4/3
f 1/1 3/2 2/3
)";

Simulation simulation_of(const std::filesystem::path& mesh, const std::string& keys = "") {
  return set_up(
      parse_scene({.text = "[body.b]\ncage.cells = [2, 2, 2]\nmesh = \"" + mesh.string() + "\"\n" + keys}, {}));
}

bool warns_of(const Simulation& simulation, const std::string& part) {
  return std::any_of(simulation.warnings.begin(), simulation.warnings.end(),
                     [&](const std::string& warning) { return contains(warning, part); });
}

/// base64 without a library.
std::string base64(const std::string& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string chunk(const char* kind, std::string bytes, char filler) {
  bytes.resize((bytes.size() + 3) / 4 * 4, filler);
  return raw(std::uint32_t(bytes.size())) + std::string(kind, 4) + bytes;
}

/// A tetrahedron as .glb, with a picture inside that its one material shows.
std::string glb_with(const std::string& picture, const std::string& kind) {
  std::string buffer;
  for (const float x : {0.f, 0.f, 0.f, 0.3f, 0.f, 0.f, 0.f, 0.4f, 0.f, 0.f, 0.f, 0.5f}) buffer += raw(x);
  for (const float u : {0.1f, 0.1f, 0.9f, 0.1f, 0.1f, 0.9f, 0.5f, 0.5f}) buffer += raw(u);
  for (const int corner : {0, 1, 3, 0, 3, 2, 1, 2, 3, 0, 2, 1}) buffer += raw(std::uint16_t(corner));
  const std::size_t before = buffer.size();
  buffer += picture;
  const std::string size = std::to_string(picture.size()), start = std::to_string(before);
  const std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[
{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]}],"materials":[{"name":"skin",
"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,1,1],"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],
"images":[{"bufferView":3,"mimeType":")" +
      kind + R"("}],"buffers":[{"byteLength":)" + std::to_string(buffer.size()) +
      R"(}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},
{"buffer":0,"byteOffset":80,"byteLength":24},{"buffer":0,"byteOffset":)" +
      start + R"(,"byteLength":)" + size +
      R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[0.3,0.4,0.5]},
{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},
{"bufferView":2,"componentType":5123,"count":12,"type":"SCALAR"}]})";
  const std::string chunks = chunk("JSON", json, ' ') + chunk("BIN\0", buffer, '\0');
  return "glTF" + raw(std::uint32_t(2)) + raw(std::uint32_t(12 + chunks.size())) + chunks;
}

/// A tetrahedron as FBX, with a picture inside.
std::string fbx_with(const std::string& picture) {
  return R"(; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7400
}
Objects:  {
	Geometry: 100, "Geometry::g", "Mesh" {
		Vertices: *12 {
			a: 0,0,0,30,0,0,0,40,0,0,0,50
		}
		PolygonVertexIndex: *12 {
			a: 0,1,-4,0,3,-3,1,2,-4,0,2,-2
		}
		LayerElementUV: 0 {
			Version: 101
			Name: "map"
			MappingInformationType: "ByPolygonVertex"
			ReferenceInformationType: "IndexToDirect"
			UV: *6 {
				a: 0.1,0.1,0.9,0.1,0.1,0.9
			}
			UVIndex: *12 {
				a: 0,1,2,0,1,2,0,1,2,0,1,2
			}
		}
		LayerElementMaterial: 0 {
			Version: 101
			MappingInformationType: "AllSame"
			ReferenceInformationType: "IndexToDirect"
			Materials: *1 {
				a: 0
			}
		}
		Layer: 0 {
			Version: 100
			LayerElement:  {
				Type: "LayerElementMaterial"
				TypedIndex: 0
			}
			LayerElement:  {
				Type: "LayerElementUV"
				TypedIndex: 0
			}
		}
	}
	Model: 200, "Model::m", "Mesh" {
		Version: 232
	}
	Material: 300, "Material::skin", "" {
		Version: 102
		ShadingModel: "lambert"
		Properties70:  {
			P: "DiffuseColor", "Color", "", "A",0.2,0.4,0.6
		}
	}
	Video: 400, "Video::v", "Clip" {
		Type: "Clip"
		Filename: "C:\art\skin.jpg"
		RelativeFilename: "skin.jpg"
		Content: ,
			")" +
         base64(picture) + R"("
	}
	Texture: 500, "Texture::t", "" {
		Type: "TextureVideoClip"
		Version: 202
		TextureName: "Texture::t"
		Media: "Video::v"
		FileName: "C:\art\skin.jpg"
		RelativeFilename: "skin.jpg"
	}
}
Connections:  {
	C: "OO",200,0
	C: "OO",100,200
	C: "OO",300,200
	C: "OP",500,300, "DiffuseColor"
	C: "OO",400,500
}
)";
}

}  // namespace

TEST_CASE("a body of several materials has a paint for each, and pictures of any format that is read") {
  const TemporaryFolder folder;
  make_file(folder / "skin.jpg", test::jpeg_bytes(test::two_colors(16, 16, red, red)));
  make_file(folder / "paint.mtl", "newmtl one\nKd 0.1 0.2 0.3\nnewmtl two\nKd 0 0 0\nmap_Kd skin.jpg\n");
  make_file(folder / "t.obj", tetrahedron);
  const Simulation simulation = simulation_of(folder / "t.obj");
  const Look& look = simulation.bodies[0].look;
  REQUIRE(look.paints.size() == 2);
  CHECK(look.paints[0].base_color == Vector3f(0.1f, 0.2f, 0.3f));
  CHECK(look.paints[0].texture == nullptr);
  REQUIRE(look.paints[1].texture);
  CHECK(look.paints[1].base_color == Vector3f(1, 1, 1));
  CHECK(look.paints[1].texture->pixel(8, 8)[0] > 0.95f);
  CHECK(simulation.bodies[0].shape.mesh.materials == std::vector<int>{0, 0, 1, 1});
  CHECK(simulation.warnings.empty());

  // a colour that the scene asks for is that of all, and multiplies the texture
  const Look asked = simulation_of(folder / "t.obj", "look.color = [0.2, 0.9, 0.4]\n").bodies[0].look;
  for (const Paint& paint : asked.paints) CHECK(paint.base_color == Vector3f(0.2f, 0.9f, 0.4f));
  CHECK(asked.paints[1].texture);
  // a texture that the scene chooses is that of all
  make_file(folder / "other.jpg", test::jpeg_bytes(test::two_colors(8, 8, blue, blue)));
  const Look chosen =
      simulation_of(folder / "t.obj", "look.texture = \"" + (folder / "other.jpg").string() + "\"\n").bodies[0].look;
  CHECK(chosen.paints.empty());
  REQUIRE(chosen.texture);
  CHECK(chosen.texture->width == 8);
}

TEST_CASE("pictures that are missing or cannot be read are a warning and the plain colour, never an end") {
  const TemporaryFolder folder;
  make_file(folder / "paint.mtl", "newmtl one\nKd 0.1 0.2 0.3\nmap_Kd skin.jpg\nnewmtl two\nmap_Kd skin.jpg\n");
  make_file(folder / "t.obj", tetrahedron);
  const auto check = [&](const std::string& part, const std::string& keys = "") {
    const Simulation simulation = simulation_of(folder / "t.obj", keys);
    CAPTURE(part);
    CHECK(warns_of(simulation, part));
    CHECK(warns_of(simulation, "drawn in the plain colour"));
    CHECK(simulation.warnings.size() == 1);  // said once
    const Look& look = simulation.bodies[0].look;
    CHECK(look.texture == nullptr);
    for (const Paint& paint : look.paints) CHECK(paint.texture == nullptr);
    if (keys.empty()) CHECK(look.paints[0].base_color == Vector3f(0.1f, 0.2f, 0.3f));
    if (keys.empty()) CHECK(look.paints[1].base_color == Look().base_color);
  };
  check("skin.jpg that the mesh names does not exist");
  const std::string whole = test::jpeg_bytes(test::two_colors(64, 64, red, blue));
  make_file(folder / "skin.jpg", whole.substr(0, whole.size() / 2));
  check("is a damaged JPEG");
  make_file(folder / "skin.jpg", "BM a format that is not read");
  check("is no picture of a known format");
  make_file(folder / "skin.jpg", "");
  check("is empty");
  check("is empty", "look.texture = \"" + (folder / "skin.jpg").string() + "\"\n");
}

TEST_CASE("pictures inside .glb and .fbx files are drawn, damaged ones are a warning") {
  const TemporaryFolder folder;
  const std::string jpeg = test::jpeg_bytes(test::two_colors(32, 16, red, blue));
  make_file(folder / "skin.glb", glb_with(jpeg, "image/jpeg"));
  make_file(folder / "skin.fbx", fbx_with(jpeg));
  for (const char* name : {"skin.glb", "skin.fbx"}) {
    CAPTURE(name);
    const Simulation simulation = simulation_of(folder / name);
    const Look& look = simulation.bodies[0].look;
    REQUIRE(look.texture);
    CHECK(look.texture->width == 32);
    CHECK(look.texture->pixel(2, 8)[0] > 0.95f);
    CHECK(look.texture->pixel(30, 8)[2] > 0.95f);
    // in glTF the colour multiplies the texture, in FBX the texture is the colour
    CHECK(look.base_color == (name == std::string("skin.glb") ? Vector3f(1, 0.5f, 1) : Vector3f(1, 1, 1)));
    CHECK(simulation.bodies[0].shape.mesh.texture_coordinates.rows() == 12);
  }
  make_file(folder / "bad.glb", glb_with(jpeg.substr(0, jpeg.size() / 2), "image/jpeg"));
  make_file(folder / "bad.fbx", fbx_with("no picture"));
  for (const char* name : {"bad.glb", "bad.fbx"}) {
    CAPTURE(name);
    const Simulation simulation = simulation_of(folder / name);
    CHECK(warns_of(simulation, "inside the mesh file"));
    CHECK(simulation.bodies[0].look.texture == nullptr);
  }
}

TEST_CASE("light gets into closed surfaces, of others what lies below is matt, and a warning says so") {
  const TemporaryFolder folder;
  make_file(folder / "closed.obj", tetrahedron);
  std::string open = tetrahedron;
  open.resize(open.rfind("f 1/1"));
  make_file(folder / "open.obj", open);
  const std::string keys = "look.transmission = 0.5\nlook.subsurface = 1\nlook.subsurface_radius = \"5 mm\"\n";
  const Simulation whole = simulation_of(folder / "closed.obj", keys),
                   broken = simulation_of(folder / "open.obj", keys);
  CHECK(whole.bodies[0].look.transmission == 0.5f);
  CHECK(whole.bodies[0].look.subsurface == 1);
  CHECK(whole.bodies[0].look.subsurface_radius == Vector3f(0.005f, 0.005f, 0.005f));
  CHECK_FALSE(warns_of(whole, "no light gets into it"));
  CHECK_FALSE(broken.bodies[0].look.lets_light_in());
  CHECK(warns_of(broken, "body.b: the surface is not closed, so no light gets into it"));
}

TEST_CASE("of obstacles light gets into balls and boxes, not into planes") {
  const std::string keys = "look.transmission = 1\n";
  const Simulation simulation = set_up(parse_scene({.text = "[body.b]\nshape = \"box\"\nposition = [0, 3, 0]\n"
                                                            "cage.cells = [2, 2, 2]\n[obstacle.ball]\n"
                                                            "shape = \"sphere\"\nradius = 0.5\n" +
                                                            keys + "[obstacle.ground]\nshape = \"plane\"\n" + keys},
                                                   {}));
  CHECK(simulation.obstacles[0].look.transmission == 1);
  CHECK(simulation.obstacles[1].look.transmission == 0);
  CHECK(warns_of(simulation, "obstacle.ground: the surface is not closed"));
}
