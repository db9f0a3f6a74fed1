#include "render/gl_raster.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
// osmesa.h brings only the old gl.h
#include <GL/glcorearb.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <mutex>

#include "core/error.h"
#include "render/raster_shaders.h"

namespace umax::raster {
namespace {

// clang-format off
#define UMAX_GL_FUNCTIONS(X)                                                                                 \
  X(GetString) X(GetIntegerv) X(GetError) X(Finish) X(PixelStorei) X(Enable) X(Disable) X(DepthFunc)         \
  X(DepthMask) X(BlendFunc) X(Viewport) X(Clear) X(ClearColor) X(PolygonOffset) X(ReadPixels) X(DrawArrays)  \
  X(DrawElements) X(CreateShader) X(ShaderSource) X(CompileShader) X(GetShaderiv) X(GetShaderInfoLog)        \
  X(DeleteShader) X(CreateProgram) X(AttachShader) X(LinkProgram) X(GetProgramiv) X(GetProgramInfoLog)       \
  X(UseProgram) X(GetUniformLocation) X(Uniform1i) X(Uniform1f) X(Uniform3fv) X(Uniform4fv)                  \
  X(UniformMatrix4fv) X(GenVertexArrays) X(BindVertexArray) X(EnableVertexAttribArray)                       \
  X(VertexAttribPointer) X(GenBuffers) X(BindBuffer) X(BufferData) X(BindBufferBase) X(GenTextures)          \
  X(BindTexture) X(ActiveTexture) X(DeleteTextures) X(TexParameteri) X(TexImage2D) X(TexImage3D)             \
  X(TexImage2DMultisample) X(GenerateMipmap) X(TexSubImage3D) X(GenFramebuffers) X(BindFramebuffer)          \
  X(FramebufferTexture2D) X(FramebufferTextureLayer) X(CheckFramebufferStatus) X(DrawBuffer) X(ReadBuffer)
// clang-format on

/// GL's functions as OSMesa hands them out. The global prototypes lend their types only; nothing links against libGL.
struct Functions {
#define UMAX_GL_DECLARE(NAME) decltype(&gl##NAME) NAME = nullptr;
  UMAX_GL_FUNCTIONS(UMAX_GL_DECLARE)
#undef UMAX_GL_DECLARE
  void load() {
#define UMAX_GL_LOAD(NAME) NAME = reinterpret_cast<decltype(NAME)>(OSMesaGetProcAddress("gl" #NAME));
    UMAX_GL_FUNCTIONS(UMAX_GL_LOAD)
#undef UMAX_GL_LOAD
  }
};

[[noreturn]] void fail(const std::string& what, const std::string& value = "") {
  throw Error(ExitCode::unavailable, {"rasteriser", what, value, "install libosmesa6, or use --engine embree"});
}

/// Settings of the environment that make llvmpipe crash, or that choose the number of its threads.
void prepare_environment(int num_threads) {
  static std::once_flag once;
  std::call_once(once, [&] {
    ::unsetenv("GALLIUM_DRIVER");
    if (const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH"); width && std::string(width) == "512")
      ::unsetenv("LP_NATIVE_VECTOR_WIDTH");
    if (num_threads > 0) ::setenv("LP_NUM_THREADS", std::to_string(num_threads).c_str(), 1);
  });
}

constexpr int unit_key_shadows = 0, unit_sky_shadows = 1, unit_probe = 2, unit_background = 3, unit_base = 4,
              unit_samples = 5;

}  // namespace

struct GlRaster::Context {
  OSMesaContext os_mesa = nullptr;
  std::vector<unsigned char> window;  // OSMesa wants one; the drawing goes to framebuffer objects
  Functions gl;
  GLuint shadow_program = 0, surface_program = 0, background_program = 0, wire_program = 0, resolve_program = 0;
  GLuint surface_array = 0, wire_array = 0, empty_array = 0, vertex_buffer = 0, index_buffer = 0, wire_buffer = 0;
  GLuint uniform_buffers[3] = {0, 0, 0};
  GLuint shadow_framebuffer = 0, sample_framebuffer = 0, result_framebuffer = 0;
  GLuint key_shadows = 0, sky_shadows = 0, probe = 0, background = 0, sample_color = 0, sample_depth = 0,
         result_color = 0;
  std::map<std::shared_ptr<const Image>, GLuint> textures;

  explicit Context(int num_threads);
  ~Context() { OSMesaDestroyContext(os_mesa); }

  void make_current();
  GLuint compile(GLenum kind, const std::string& source);
  GLuint link(const std::string& vertex_source, const std::string& fragment_source);
  GLint location(GLuint program, const char* name) { return gl.GetUniformLocation(program, name); }
  void set(GLuint program, const char* name, const Matrix4f& value) {
    gl.UniformMatrix4fv(location(program, name), 1, GL_FALSE, value.data());
  }
  void set(GLuint program, const char* name, const Vector4f& value) {
    gl.Uniform4fv(location(program, name), 1, value.data());
  }
  void set(GLuint program, const char* name, const Vector3f& value) {
    gl.Uniform3fv(location(program, name), 1, value.data());
  }
  void set(GLuint program, const char* name, float value) { gl.Uniform1f(location(program, name), value); }
  void set(GLuint program, const char* name, int value) { gl.Uniform1i(location(program, name), value); }
  GLuint make_texture(GLenum target, int unit, GLint filter, GLint wrap_s, GLint wrap_t);
  void check_framebuffer(const char* what);

  void upload_geometry(const Frame& frame);
  void upload_lights(const Frame& frame);
  void upload_surroundings(const Frame& frame);
  void prepare_targets(int width, int height);
  void draw_shadows(const Frame& frame, const std::vector<LightSample>& samples, GLuint maps, int unit, int size);
  void draw_background(const Frame& frame);
  void draw_surfaces(const Frame& frame);
  void draw_wires(const Frame& frame);
  GLuint texture_of(const std::shared_ptr<const Image>& image);
  Image read_result(int width, int height);
};

GlRaster::Context::Context(int num_threads) {
  prepare_environment(num_threads);
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_DEPTH_BITS,
                            24,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            4,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            5,
                            0};
  os_mesa = OSMesaCreateContextAttribs(attributes, nullptr);
  if (!os_mesa) fail("OSMesa gives no GL 4.5 core context");
  window.resize(16 * 16 * 4);
  make_current();
  gl.load();  // the loader answers for unknown names too: the version says what is really there
  GLint major = 0, minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (10 * major + minor < 45) fail("needs GL 4.5", std::to_string(major) + "." + std::to_string(minor));

  const std::string with_surroundings = std::string("#version 450 core\n") + surroundings;
  shadow_program = link(shadow_vertex_shader, shadow_fragment_shader);
  surface_program = link(surface_vertex_shader, with_surroundings + surface_fragment_shader);
  background_program = link(background_vertex_shader, with_surroundings + background_fragment_shader);
  wire_program = link(wire_vertex_shader, wire_fragment_shader);
  resolve_program = link(resolve_vertex_shader, resolve_fragment_shader);

  gl.GenVertexArrays(1, &surface_array);
  gl.GenVertexArrays(1, &wire_array);
  gl.GenVertexArrays(1, &empty_array);
  gl.GenBuffers(1, &vertex_buffer);
  gl.GenBuffers(1, &index_buffer);
  gl.GenBuffers(1, &wire_buffer);
  gl.GenBuffers(3, uniform_buffers);
  gl.GenFramebuffers(1, &shadow_framebuffer);
  gl.GenFramebuffers(1, &sample_framebuffer);
  gl.GenFramebuffers(1, &result_framebuffer);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
}

void GlRaster::Context::make_current() {
  if (!OSMesaMakeCurrent(os_mesa, window.data(), GL_UNSIGNED_BYTE, 16, 16)) fail("OSMesa refuses its context");
}

GLuint GlRaster::Context::compile(GLenum kind, const std::string& source) {
  const GLuint shader = gl.CreateShader(kind);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (!compiled) {
    char log[2048] = "";
    gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
    fail("a shader does not compile", log);
  }
  return shader;
}

GLuint GlRaster::Context::link(const std::string& vertex_source, const std::string& fragment_source) {
  const GLuint program = gl.CreateProgram();
  for (const GLuint shader : {compile(GL_VERTEX_SHADER, vertex_source), compile(GL_FRAGMENT_SHADER, fragment_source)}) {
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  GLint linked = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) {
    char log[2048] = "";
    gl.GetProgramInfoLog(program, sizeof log, nullptr, log);
    fail("the shaders do not link", log);
  }
  return program;
}

GLuint GlRaster::Context::make_texture(GLenum target, int unit, GLint filter, GLint wrap_s, GLint wrap_t) {
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(target, texture);
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, filter == GL_NEAREST ? GL_NEAREST : GL_LINEAR);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_S, wrap_s);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_T, wrap_t);
  return texture;
}

void GlRaster::Context::check_framebuffer(const char* what) {
  const GLenum status = gl.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) fail(std::string(what) + " cannot be drawn to", std::to_string(status));
}

void GlRaster::Context::upload_geometry(const Frame& frame) {
  const auto offset = [](std::size_t bytes) { return reinterpret_cast<const void*>(bytes); };
  gl.BindVertexArray(surface_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer);
  gl.BufferData(GL_ARRAY_BUFFER, GLsizeiptr(frame.vertices.size() * sizeof(Vertex)), frame.vertices.data(),
                GL_STREAM_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(frame.indices.size() * 4), frame.indices.data(), GL_STREAM_DRAW);
  const struct {
    int count;
    std::size_t offset;
  } fields[] = {{3, offsetof(Vertex, position)},
                {3, offsetof(Vertex, normal)},
                {3, offsetof(Vertex, color)},
                {2, offsetof(Vertex, texture_coordinate)}};
  for (GLuint i = 0; i < 4; ++i) {
    gl.EnableVertexAttribArray(i);
    gl.VertexAttribPointer(i, fields[i].count, GL_FLOAT, GL_FALSE, sizeof(Vertex), offset(fields[i].offset));
  }
  gl.BindVertexArray(wire_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, wire_buffer);
  gl.BufferData(GL_ARRAY_BUFFER, GLsizeiptr(frame.wires.size() * sizeof(WireVertex)), frame.wires.data(),
                GL_STREAM_DRAW);
  gl.EnableVertexAttribArray(0);
  gl.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(WireVertex), offset(offsetof(WireVertex, clip)));
  gl.EnableVertexAttribArray(1);
  gl.VertexAttribPointer(1, 1, GL_FLOAT, GL_FALSE, sizeof(WireVertex), offset(offsetof(WireVertex, distance)));
}

void GlRaster::Context::upload_lights(const Frame& frame) {
  // whole arrays: a block smaller than the shader's declaration may not be bound
  const auto upload = [&](GLuint index, const auto& values, std::size_t capacity) {
    auto padded = values;
    padded.resize(capacity);
    gl.BindBuffer(GL_UNIFORM_BUFFER, uniform_buffers[index]);
    gl.BufferData(GL_UNIFORM_BUFFER, GLsizeiptr(capacity * sizeof padded[0]), padded.data(), GL_STREAM_DRAW);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, index, uniform_buffers[index]);
  };
  upload(0, frame.key_samples, max_key_samples);
  upload(1, frame.sky_samples, max_sky_samples);
  upload(2, frame.key_lights, max_key_lights);
}

void GlRaster::Context::upload_surroundings(const Frame& frame) {
  if (!probe) {
    probe = make_texture(GL_TEXTURE_2D_ARRAY, unit_probe, GL_LINEAR, GL_REPEAT, GL_CLAMP_TO_EDGE);
    background = make_texture(GL_TEXTURE_2D, unit_background, GL_LINEAR, GL_REPEAT, GL_CLAMP_TO_EDGE);
  }
  const Image& first = frame.probe.front();
  gl.ActiveTexture(GL_TEXTURE0 + unit_probe);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, probe);
  gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGB32F, first.width, first.height, num_probe_layers, 0, GL_RGB, GL_FLOAT,
                nullptr);
  for (int layer = 0; layer < num_probe_layers; ++layer) {
    gl.TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, first.width, first.height, 1, GL_RGB, GL_FLOAT,
                     frame.probe[layer].values.data());
  }
  gl.ActiveTexture(GL_TEXTURE0 + unit_background);
  gl.BindTexture(GL_TEXTURE_2D, background);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F, frame.background.width, frame.background.height, 0, GL_RGB, GL_FLOAT,
                frame.background.values.data());
}

void GlRaster::Context::prepare_targets(int width, int height) {
  for (GLuint* texture : {&sample_color, &sample_depth, &result_color}) {
    if (*texture) gl.DeleteTextures(1, texture);
    gl.GenTextures(1, texture);
  }
  gl.ActiveTexture(GL_TEXTURE0 + unit_samples);
  gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, sample_depth);
  gl.TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, 4, GL_DEPTH_COMPONENT32F, width, height, GL_TRUE);
  gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, sample_color);
  gl.TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, 4, GL_RGBA16F, width, height, GL_TRUE);
  gl.BindFramebuffer(GL_FRAMEBUFFER, sample_framebuffer);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D_MULTISAMPLE, sample_color, 0);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D_MULTISAMPLE, sample_depth, 0);
  check_framebuffer("the multisampled picture");
  gl.BindTexture(GL_TEXTURE_2D, result_color);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
  gl.BindFramebuffer(GL_FRAMEBUFFER, result_framebuffer);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, result_color, 0);
  check_framebuffer("the picture");
}

void GlRaster::Context::draw_shadows(const Frame& frame, const std::vector<LightSample>& samples, GLuint maps, int unit,
                                     int size) {
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, maps);
  const GLsizei num_layers = GLsizei(std::max<std::size_t>(samples.size(), 1));
  gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, size, size, num_layers, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                nullptr);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  gl.BindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer);
  gl.DrawBuffer(GL_NONE);
  gl.ReadBuffer(GL_NONE);
  gl.Viewport(0, 0, size, size);
  gl.Enable(GL_DEPTH_TEST);
  gl.Enable(GL_DEPTH_CLAMP);  // what lies before the near plane still throws its shadow
  gl.DepthFunc(GL_LESS);
  gl.UseProgram(shadow_program);
  gl.BindVertexArray(surface_array);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    gl.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, maps, 0, GLint(i));
    if (i == 0) check_framebuffer("the shadow map");
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    set(shadow_program, "shadow_from_world", samples[i].shadow_from_world);
    for (const Batch& batch : frame.batches) {
      if (batch.is_ground) continue;
      gl.DrawElements(GL_TRIANGLES, batch.num_indices, GL_UNSIGNED_INT,
                      reinterpret_cast<const void*>(std::size_t(batch.first_index) * 4));
    }
  }
  gl.Disable(GL_DEPTH_CLAMP);
}

void GlRaster::Context::draw_background(const Frame& frame) {
  gl.Disable(GL_DEPTH_TEST);
  gl.UseProgram(background_program);
  set(background_program, "world_from_clip", frame.world_from_clip);
  set(background_program, "eye", frame.eye);
  set(background_program, "background_map", unit_background);
  set(background_program, "sun", frame.sun);
  set(background_program, "sun_radiance", frame.sun_radiance);
  gl.BindVertexArray(empty_array);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.Enable(GL_DEPTH_TEST);
}

GLuint GlRaster::Context::texture_of(const std::shared_ptr<const Image>& image) {
  if (const auto found = textures.find(image); found != textures.end()) return found->second;
  const GLuint texture = make_texture(GL_TEXTURE_2D, unit_base, GL_LINEAR_MIPMAP_LINEAR, GL_REPEAT, GL_REPEAT);
  const GLenum format = image->channels == 1 ? GL_RED : image->channels == 4 ? GL_RGBA : GL_RGB;
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB16F, image->width, image->height, 0, format, GL_FLOAT, image->values.data());
  gl.GenerateMipmap(GL_TEXTURE_2D);
  return textures[image] = texture;
}

void GlRaster::Context::draw_surfaces(const Frame& frame) {
  const GLuint program = surface_program;
  gl.DepthFunc(GL_LESS);
  gl.UseProgram(program);
  set(program, "clip_from_world", frame.clip_from_world);
  set(program, "eye", frame.eye);
  set(program, "num_key_lights", int(frame.key_lights.size()));
  set(program, "num_sky_samples", int(frame.sky_samples.size()));
  set(program, "key_shadows", unit_key_shadows);
  set(program, "sky_shadows", unit_sky_shadows);
  set(program, "probe", unit_probe);
  set(program, "background_map", unit_background);
  set(program, "base_texture", unit_base);
  set(program, "sun", frame.sun);
  set(program, "sun_radiance", frame.sun_radiance);
  set(program, "ground_fade", frame.ground_fade);
  gl.BindVertexArray(surface_array);
  for (const Batch& batch : frame.batches) {
    set(program, "surface", batch.surface);
    set(program, "coat_roughness", batch.coat_roughness);
    set(program, "is_ground", int(batch.is_ground));
    set(program, "textured", int(batch.texture != nullptr));
    if (batch.texture) {
      const GLuint texture = texture_of(batch.texture);
      gl.ActiveTexture(GL_TEXTURE0 + unit_base);
      gl.BindTexture(GL_TEXTURE_2D, texture);
    }
    gl.DrawElements(GL_TRIANGLES, batch.num_indices, GL_UNSIGNED_INT,
                    reinterpret_cast<const void*>(std::size_t(batch.first_index) * 4));
  }
}

void GlRaster::Context::draw_wires(const Frame& frame) {
  if (frame.wires.empty()) return;
  gl.UseProgram(wire_program);
  gl.BindVertexArray(wire_array);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl.DepthMask(GL_FALSE);
  set(wire_program, "color", frame.wire_color);
  set(wire_program, "half_width", frame.wire_half_width);
  const auto pass = [&](GLenum depth_function, float opacity) {
    gl.DepthFunc(depth_function);
    set(wire_program, "opacity", opacity);
    gl.DrawArrays(GL_TRIANGLES, 0, GLsizei(frame.wires.size()));
  };
  if (frame.hidden_wire_opacity > 0) pass(GL_GREATER, frame.hidden_wire_opacity);
  pass(GL_LEQUAL, frame.wire_opacity);
  gl.DepthMask(GL_TRUE);
  gl.Disable(GL_BLEND);
}

Image GlRaster::Context::read_result(int width, int height) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, result_framebuffer);
  gl.Disable(GL_DEPTH_TEST);
  gl.UseProgram(resolve_program);
  gl.ActiveTexture(GL_TEXTURE0 + unit_samples);
  gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, sample_color);
  set(resolve_program, "samples", unit_samples);
  gl.BindVertexArray(empty_array);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  Image flipped(width, height, 3), image(width, height, 3);
  gl.ReadPixels(0, 0, width, height, GL_RGB, GL_FLOAT, flipped.values.data());
  for (int y = 0; y < height; ++y) std::copy_n(flipped.pixel(0, height - 1 - y), 3 * width, image.pixel(0, y));
  return image;
}

GlRaster::GlRaster(int num_threads) : context_(std::make_unique<Context>(num_threads)) {}
GlRaster::~GlRaster() = default;

Image GlRaster::draw(const Frame& frame) {
  Context& context = *context_;
  const Functions& gl = context.gl;
  context.make_current();
  context.upload_geometry(frame);
  context.upload_lights(frame);
  context.upload_surroundings(frame);
  if (!context.key_shadows) {
    context.key_shadows =
        context.make_texture(GL_TEXTURE_2D_ARRAY, unit_key_shadows, GL_LINEAR, GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
    context.sky_shadows =
        context.make_texture(GL_TEXTURE_2D_ARRAY, unit_sky_shadows, GL_LINEAR, GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
  }
  context.draw_shadows(frame, frame.key_samples, context.key_shadows, unit_key_shadows, frame.key_map_size);
  context.draw_shadows(frame, frame.sky_samples, context.sky_shadows, unit_sky_shadows, frame.sky_map_size);

  context.prepare_targets(frame.width, frame.height);
  gl.BindFramebuffer(GL_FRAMEBUFFER, context.sample_framebuffer);
  gl.Viewport(0, 0, frame.width, frame.height);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  context.draw_background(frame);
  context.draw_surfaces(frame);
  context.draw_wires(frame);
  Image image = context.read_result(frame.width, frame.height);
  if (const GLenum error = gl.GetError(); error != GL_NO_ERROR) fail("GL reports an error", std::to_string(error));
  return image;
}

}  // namespace umax::raster
