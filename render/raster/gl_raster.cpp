#include "render/raster/gl_raster.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
// osmesa.h brings only the old gl.h
#include <GL/glcorearb.h>
#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <map>
#include <type_traits>

#include "core/base/error.h"
#include "render/raster/llvmpipe.h"
#include "render/raster/raster_shaders.h"

namespace umax::raster {
namespace {

// clang-format off
#define UMAX_GL_FUNCTIONS(X)                                                                                 \
  X(GetIntegerv) X(GetError) X(PixelStorei) X(Enable) X(Disable) X(DepthFunc) X(DepthMask) X(BlendFunc)      \
  X(Viewport) X(Clear) X(ClearColor) X(ReadPixels) X(ReadBuffer) X(DrawBuffers) X(DrawArrays)                \
  X(DrawElements) X(CreateShader) X(ShaderSource) X(CompileShader) X(GetShaderiv) X(GetShaderInfoLog)        \
  X(DeleteShader) X(CreateProgram) X(AttachShader) X(LinkProgram) X(GetProgramiv) X(GetProgramInfoLog)       \
  X(UseProgram) X(GetUniformLocation) X(Uniform1i) X(Uniform1f) X(Uniform3fv) X(UniformMatrix4fv)            \
  X(GenVertexArrays) X(BindVertexArray) X(EnableVertexAttribArray) X(VertexAttribPointer) X(GenBuffers)      \
  X(BindBuffer) X(BufferData) X(GenTextures) X(BindTexture) X(ActiveTexture) X(DeleteTextures)               \
  X(TexParameteri) X(TexImage2D) X(TexImage2DMultisample) X(GenerateMipmap) X(GenFramebuffers)               \
  X(BindFramebuffer) X(FramebufferTexture2D) X(CheckFramebufferStatus)
// clang-format on

[[noreturn]] void fail(const std::string& what, const std::string& value = "") {
  throw Error(Fault::unavailable, {"rasteriser", what, value, "install libosmesa6, or use --engine embree"});
}

/// OSMesa's functions. The global prototypes lend their types only: the library is loaded when the first picture is drawn, as
/// loading its compiler takes longer than most commands, which draw none.
struct OsMesa {
  decltype(&OSMesaCreateContextAttribs) create_context;
  decltype(&OSMesaDestroyContext) destroy_context;
  decltype(&OSMesaMakeCurrent) make_current;
  decltype(&OSMesaGetProcAddress) get_function;
};

OsMesa load_os_mesa() {
  void* library =
      dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);  // for good: it may not be unloaded while threads run
  if (!library) fail("OSMesa cannot be loaded", dlerror());
  const auto load = [&](const char* name, auto& function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (!function) fail("OSMesa lacks a function", name);
  };
  OsMesa mesa{};
  load("OSMesaCreateContextAttribs", mesa.create_context);
  load("OSMesaDestroyContext", mesa.destroy_context);
  load("OSMesaMakeCurrent", mesa.make_current);
  load("OSMesaGetProcAddress", mesa.get_function);
  return mesa;
}

const OsMesa& os_mesa() {
  static const OsMesa mesa = load_os_mesa();
  return mesa;
}

/// GL's functions as OSMesa hands them out; nothing links against libGL.
struct Functions {
// NOLINTNEXTLINE(bugprone-macro-parentheses): NAME is declared
#define UMAX_GL_DECLARE(NAME) decltype(&gl##NAME) NAME = nullptr;
  UMAX_GL_FUNCTIONS(UMAX_GL_DECLARE)
#undef UMAX_GL_DECLARE
  void load() {
#define UMAX_GL_LOAD(NAME) NAME = reinterpret_cast<decltype(NAME)>(os_mesa().get_function("gl" #NAME));
    UMAX_GL_FUNCTIONS(UMAX_GL_LOAD)
#undef UMAX_GL_LOAD
  }
};

constexpr int unit_base = 0, unit_samples = 1;

/// A multisampled picture that is drawn to.
struct Target {
  GLuint texture = 0;
  GLenum attachment = 0, format = 0;
};

}  // namespace

struct GlRaster::Context {
  OSMesaContext context = nullptr;
  std::vector<unsigned char> window;  // OSMesa wants one; the drawing goes to framebuffer objects
  Functions gl;
  GLuint surface_program = 0, wire_program = 0, pick_program = 0;
  GLuint surface_array = 0, wire_array = 0, empty_array = 0, vertex_buffer = 0, index_buffer = 0, wire_buffer = 0;
  GLuint surface_framebuffer = 0, wire_framebuffer = 0, picked_framebuffer = 0;
  Target geometry{0, GL_COLOR_ATTACHMENT0, GL_RGBA32F}, material{0, GL_COLOR_ATTACHMENT1, GL_RGBA32F};
  Target wires{0, GL_COLOR_ATTACHMENT0, GL_RGBA16F}, depth{0, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F};
  GLuint picked = 0;
  int width = 0, height = 0;  // [px] of the targets
  std::map<std::shared_ptr<const Image>, GLuint> textures;

  explicit Context(int num_threads);
  ~Context() { os_mesa().destroy_context(context); }

  void make_current();
  GLuint compile(GLenum kind, const std::string& source);
  GLuint link(const char* vertex_source, const char* fragment_source);
  GLint location(GLuint program, const char* name) { return gl.GetUniformLocation(program, name); }
  void set(GLuint program, const char* name, const Vector3f& value) {
    gl.Uniform3fv(location(program, name), 1, value.data());
  }
  void set(GLuint program, const char* name, float value) { gl.Uniform1f(location(program, name), value); }
  void set(GLuint program, const char* name, int value) { gl.Uniform1i(location(program, name), value); }
  void check_framebuffer(const char* what);

  void upload_geometry(const Frame& frame);
  void prepare_targets(int new_width, int new_height);
  void attach(GLuint framebuffer, std::initializer_list<Target*> targets, const char* what);
  void draw_surfaces(const Frame& frame);
  void draw_wires(const Frame& frame);
  GLuint texture_of(const std::shared_ptr<const Image>& image);
  void pick(const Target& target, int sample_index, float* out);
};

GlRaster::Context::Context(int num_threads) {
  const DriverEnvironment environment(num_threads);
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
  context = os_mesa().create_context(attributes, nullptr);
  if (!context) fail("OSMesa gives no GL 4.5 core context");
  window.resize(16 * 16 * 4);
  make_current();
  gl.load();  // the loader answers for unknown names too: the version says what is really there
  GLint major = 0, minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (10 * major + minor < 45) fail("needs GL 4.5", std::to_string(major) + "." + std::to_string(minor));

  surface_program = link(surface_vertex_shader, surface_fragment_shader);
  wire_program = link(wire_vertex_shader, wire_fragment_shader);
  pick_program = link(full_vertex_shader, pick_fragment_shader);
  for (GLuint* array : {&surface_array, &wire_array, &empty_array}) gl.GenVertexArrays(1, array);
  for (GLuint* buffer : {&vertex_buffer, &index_buffer, &wire_buffer}) gl.GenBuffers(1, buffer);
  for (GLuint* buffer : {&surface_framebuffer, &wire_framebuffer, &picked_framebuffer}) gl.GenFramebuffers(1, buffer);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
}

void GlRaster::Context::make_current() {
  if (!os_mesa().make_current(context, window.data(), GL_UNSIGNED_BYTE, 16, 16)) fail("OSMesa refuses its context");
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

GLuint GlRaster::Context::link(const char* vertex_source, const char* fragment_source) {
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

void GlRaster::Context::check_framebuffer(const char* what) {
  const GLenum status = gl.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) fail(std::string(what) + " cannot be drawn to", std::to_string(status));
}

void GlRaster::Context::upload_geometry(const Frame& frame) {
  const auto attribute = [&](GLuint index, int count, std::size_t stride, std::size_t offset) {
    gl.EnableVertexAttribArray(index);
    // NOLINTNEXTLINE(performance-no-int-to-ptr): GL takes offsets as pointers
    gl.VertexAttribPointer(index, count, GL_FLOAT, GL_FALSE, GLsizei(stride), reinterpret_cast<const void*>(offset));
  };
  const auto upload = [&](GLenum target, GLuint buffer, const auto& values) {
    gl.BindBuffer(target, buffer);
    gl.BufferData(target, GLsizeiptr(values.size() * sizeof values[0]), values.data(), GL_STREAM_DRAW);
  };
  gl.BindVertexArray(surface_array);
  upload(GL_ARRAY_BUFFER, vertex_buffer, frame.vertices);
  upload(GL_ELEMENT_ARRAY_BUFFER, index_buffer, frame.indices);
  attribute(0, 3, sizeof(Vertex), offsetof(Vertex, position));
  attribute(1, 3, sizeof(Vertex), offsetof(Vertex, normal));
  attribute(2, 3, sizeof(Vertex), offsetof(Vertex, color));
  attribute(3, 2, sizeof(Vertex), offsetof(Vertex, texture_coordinate));
  gl.BindVertexArray(wire_array);
  upload(GL_ARRAY_BUFFER, wire_buffer, frame.wires);
  attribute(0, 4, sizeof(WireVertex), offsetof(WireVertex, clip));
  attribute(1, 1, sizeof(WireVertex), offsetof(WireVertex, distance));
}

void GlRaster::Context::attach(GLuint framebuffer, std::initializer_list<Target*> targets, const char* what) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  std::vector<GLenum> colors;
  for (const Target* target : targets) {
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, target->attachment, GL_TEXTURE_2D_MULTISAMPLE, target->texture, 0);
    if (target->attachment != GL_DEPTH_ATTACHMENT) colors.push_back(target->attachment);
  }
  gl.DrawBuffers(GLsizei(colors.size()), colors.data());
  check_framebuffer(what);
}

void GlRaster::Context::prepare_targets(int new_width, int new_height) {
  if (width == new_width && height == new_height) return;
  width = new_width;
  height = new_height;
  for (Target* target : {&geometry, &material, &wires, &depth}) {
    if (target->texture) gl.DeleteTextures(1, &target->texture);
    gl.GenTextures(1, &target->texture);
    gl.ActiveTexture(GL_TEXTURE0 + unit_samples);
    gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, target->texture);
    gl.TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, samples_per_pixel, target->format, width, height, GL_TRUE);
  }
  attach(surface_framebuffer, {&geometry, &material, &depth}, "the surfaces' picture");
  attach(wire_framebuffer, {&wires, &depth}, "the wires' picture");

  if (picked) gl.DeleteTextures(1, &picked);
  gl.GenTextures(1, &picked);
  gl.BindTexture(GL_TEXTURE_2D, picked);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
  gl.BindFramebuffer(GL_FRAMEBUFFER, picked_framebuffer);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picked, 0);
  check_framebuffer("the picture");
}

GLuint GlRaster::Context::texture_of(const std::shared_ptr<const Image>& image) {
  if (const auto found = textures.find(image); found != textures.end()) return found->second;
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.ActiveTexture(GL_TEXTURE0 + unit_base);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  const GLenum format = image->channels == 1 ? GL_RED : image->channels == 4 ? GL_RGBA : GL_RGB;
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB16F, image->width, image->height, 0, format, GL_FLOAT, image->values.data());
  if (format == GL_RED) {
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_G, GL_RED);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_B, GL_RED);
  }
  gl.GenerateMipmap(GL_TEXTURE_2D);
  return textures[image] = texture;
}

void GlRaster::Context::draw_surfaces(const Frame& frame) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, surface_framebuffer);
  gl.Viewport(0, 0, width, height);
  gl.ClearColor(0, 0, 0, 0);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LESS);
  gl.UseProgram(surface_program);
  gl.UniformMatrix4fv(location(surface_program, "clip_from_world"), 1, GL_FALSE, frame.clip_from_world.data());
  set(surface_program, "eye", frame.eye);
  set(surface_program, "base_texture", unit_base);
  gl.BindVertexArray(surface_array);
  for (std::size_t i = 0; i < frame.batches.size(); ++i) {
    const Batch& batch = frame.batches[i];
    set(surface_program, "batch", float(i));
    set(surface_program, "textured", int(batch.texture != nullptr));
    if (batch.texture) {
      const GLuint texture = texture_of(batch.texture);
      gl.ActiveTexture(GL_TEXTURE0 + unit_base);
      gl.BindTexture(GL_TEXTURE_2D, texture);
    }
    // NOLINTNEXTLINE(performance-no-int-to-ptr): GL takes offsets as pointers
    const auto first = reinterpret_cast<const void*>(std::size_t(batch.first_index) * sizeof(std::uint32_t));
    gl.DrawElements(GL_TRIANGLES, batch.num_indices, GL_UNSIGNED_INT, first);
  }
}

void GlRaster::Context::draw_wires(const Frame& frame) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, wire_framebuffer);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  gl.UseProgram(wire_program);
  gl.BindVertexArray(wire_array);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
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

/// Reads one sample of each pixel, or the mean (sample_index < 0): 4 floats a pixel, rows from the top.
void GlRaster::Context::pick(const Target& target, int sample_index, float* out) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, picked_framebuffer);
  gl.Disable(GL_DEPTH_TEST);
  gl.UseProgram(pick_program);
  gl.ActiveTexture(GL_TEXTURE0 + unit_samples);
  gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, target.texture);
  set(pick_program, "samples", unit_samples);
  set(pick_program, "sample_index", sample_index);
  gl.BindVertexArray(empty_array);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, out);
  const std::size_t row = std::size_t(width) * 4;
  for (int y = 0; y < height / 2; ++y)
    std::swap_ranges(out + row * y, out + row * (y + 1), out + row * (height - 1 - y));
}

void require_os_mesa() {
  os_mesa();
}

GlRaster::GlRaster(int num_threads) : context_(std::make_unique<Context>(num_threads)) {}
GlRaster::~GlRaster() = default;

Visible GlRaster::draw(const Frame& frame) {
  Context& context = *context_;
  context.make_current();
  context.upload_geometry(frame);
  context.prepare_targets(frame.width, frame.height);
  context.draw_surfaces(frame);
  if (!frame.wires.empty()) context.draw_wires(frame);

  Visible visible;
  visible.width = frame.width;
  visible.height = frame.height;
  const std::size_t layer = std::size_t(frame.width) * frame.height * 4;
  visible.geometry.resize(layer * samples_per_pixel);
  visible.material.resize(layer * samples_per_pixel);
  for (int s = 0; s < samples_per_pixel; ++s) {
    context.pick(context.geometry, s, &visible.geometry[layer * s]);
    context.pick(context.material, s, &visible.material[layer * s]);
  }
  if (!frame.wires.empty()) {
    visible.wires = Image(frame.width, frame.height, 4);
    context.pick(context.wires, -1, visible.wires.values.data());
  }
  if (const GLenum error = context.gl.GetError(); error != GL_NO_ERROR)
    fail("GL reports an error", std::to_string(error));
  return visible;
}

}  // namespace umax::raster
