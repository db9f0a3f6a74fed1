// One small mesh as a document of every format: a quad and a triangle that share an edge, in known vertex order.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace umax::testing {

/// Five vertices, deliberately not in the order in which the faces use them; one quad, one triangle.
inline const char* const obj_document = R"(# two faces
mtllib paint.mtl
v 2 0.5 0
v 0 0 0
v 1 1 0
v 1 0 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vt 0.5 0.5
usemtl red
o first
f 2/1 4/2 3/3 5/4
o second
f -2/2 1/5 3/3
)";

inline const char* const ply_document = R"(ply
format ascii 1.0
comment made by hand
element vertex 5
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
end_header
2 0.5 0 255 0 0
0 0 0 188 188 188
1 1 0 0 0 255
1 0 0 0 255 0
0 1 0 255 255 255
4 1 3 2 4
3 3 0 2
)";

inline const char* const off_document = R"(OFF
# by hand
5 2 0
2 0.5 0
0 0 0
1 1 0
1 0 0
0 1 0
4 1 3 2 4
3 3 0 2
)";

inline const char* const stl_document = R"(solid two
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 1 1 0
endloop
endfacet
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 1 0
vertex 0 1 0
endloop
endfacet
endsolid two
)";

/// Two facets as a binary STL file.
inline std::string binary_stl() {
  const float facets[2][12] = {{0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 0}};
  std::string text(80, ' ');
  const std::uint32_t count = 2;
  text.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& facet : facets) {
    text.append(reinterpret_cast<const char*>(facet), sizeof facet);
    text.append(2, '\0');
  }
  return text;
}

/// Triangle (0,0,0) (1,0,0) (0,1,0), drawn by two nodes: as it is, and moved by 10 along x.
inline const char* const gltf_document = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0},{"mesh":0,"translation":[10,0,0]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":1},"indices":0,"mode":4}]}],
"buffers":[{"byteLength":44,"uri":"data:application/octet-stream;base64,AAABAAIAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAAAA="}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":6},{"buffer":0,"byteOffset":8,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5123,"count":3,"type":"SCALAR"},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}
)";

/// A quad and a triangle in inches, Z up, in a node that moves them by (0, 0, 5).
inline const char* const collada_document = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified><unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="15">2 0.5 0 0 0 0 1 1 0 1 0 0 0 1 0</float_array>
<technique_common><accessor source="#pa" count="5" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="2"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4 3</vcount><p>1 3 2 4 3 0 2</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s" name="s"><node id="n" name="n"><translate>0 0 5</translate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";

/// A quad and a triangle in centimetres (factor 1) with Z up.
inline const char* const fbx_document = R"(; FBX 7.3.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7300
}
GlobalSettings:  {
	Version: 1000
	Properties70:  {
		P: "UpAxis", "int", "Integer", "",2
		P: "UpAxisSign", "int", "Integer", "",1
		P: "FrontAxis", "int", "Integer", "",1
		P: "FrontAxisSign", "int", "Integer", "",-1
		P: "CoordAxis", "int", "Integer", "",0
		P: "CoordAxisSign", "int", "Integer", "",1
		P: "UnitScaleFactor", "double", "Number", "",1
	}
}
Objects:  {
	Geometry: 100, "Geometry::g", "Mesh" {
		Vertices: *15 {
			a: 2,0.5,0,0,0,0,1,1,0,1,0,0,0,1,0
		}
		PolygonVertexIndex: *7 {
			a: 1,3,2,-5,3,0,-3
		}
		GeometryVersion: 124
	}
	Model: 200, "Model::m", "Mesh" {
		Version: 232
		Properties70:  {
			P: "Lcl Translation", "Lcl Translation", "", "A",0,0,5
		}
	}
}
Connections:  {
	C: "OO",200,0
	C: "OO",100,200
}
)";

}  // namespace umax::testing
