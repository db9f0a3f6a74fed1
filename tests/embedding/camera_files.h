// Files with an animated camera: glTF as text and binary, USD as text.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "tests/embedding/raw_bytes.h"

namespace umax::testing {

inline std::string floats(const std::vector<float>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
}

/// A camera that goes from (1, 2, 3) to (5, 2, 3) in 2 s from 0.5 s on and turns by 90 degrees to the left meanwhile, on a
/// platform at (0, 10, 0) that is twice as large.
inline std::string gltf_text(const std::string& uri, const std::string& interpolation = "LINEAR") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"name":"platform","translation":[0,10,0],"scale":[2,2,2],"children":[1]},{"name":"shot","camera":0,"translation":[9,9,9]}],
"cameras":[{"name":"lens","type":"perspective","perspective":{"yfov":0.5,"znear":0.1,"aspectRatio":1.5}}],
"animations":[{"channels":[{"sampler":0,"target":{"node":1,"path":"translation"}},{"sampler":1,"target":{"node":1,"path":"rotation"}}],
"samplers":[{"input":0,"output":1,"interpolation":")" +
         interpolation + R"("},{"input":0,"output":2}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR"},
{"bufferView":0,"byteOffset":8,"componentType":5126,"count":2,"type":"VEC3"},
{"bufferView":0,"byteOffset":32,"componentType":5126,"count":2,"type":"VEC4"}],
"bufferViews":[{"buffer":0,"byteLength":64}],"buffers":[{)" +
         uri + R"("byteLength":64}]})";
}

inline std::string animation_bytes() {
  const auto half = float(std::sqrt(0.5));
  return floats({0.5f, 2.5f, 1, 2, 3, 5, 2, 3, 0, 0, 0, 1, 0, half, 0, half});
}

inline std::string data_uri(const std::string& bytes) {
  return R"("uri":"data:application/octet-stream;base64,)" + base64(bytes) + R"(",)";
}

inline std::string glb(std::string text, std::string binary) {
  while (text.size() % 4 != 0) text += ' ';
  const auto word = [](std::size_t number) {
    const auto value = std::uint32_t(number);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &value, 4);
    return bytes;
  };
  return "glTF" + word(2) + word(28 + text.size() + binary.size()) + word(text.size()) + "JSON" + text +
         word(binary.size()) + std::string("BIN\0", 4) + binary;
}

/// A camera that looks down by 90 degrees and moves, among things that mean nothing to cameras.
inline const char* const usda = R"usd(#usda 1.0
(
    "a comment with ( and )"
    defaultPrim = "root"
    metersPerUnit = 0.01
    startTimeCode = 10
    timeCodesPerSecond = 20
    upAxis = "Z"
)

def Xform "root" (
    prepend references = @./other.usda@</x>
    customData = { string note = "} not the end" }
)
{
    float3 xformOp:rotateXYZ = (90, 0, 90)
    double3 xformOp:translate:pivot = (100, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate:pivot", "xformOp:rotateXYZ", "!invert!xformOp:translate:pivot"]
    custom string empty
    rel things = [</root/a>, </root/b>]

    def Mesh "large"
    {
        point3f[] points = [(0, 0, 0), (1, 1, 1)] (
            interpolation = "vertex"
        )
    }
    def Camera "shot"
    {
        float focalLength = 50  # a remark
        float focalLength.timeSamples = {
            10: 50,
            30: 100,
        }
        float verticalAperture = 25
        token projection = "perspective"
        double3 xformOp:translate.timeSamples = { 10: (100, 0, 0), 30: (100, 200, 0), 40: None }
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    variantSet "look" = {
        "red" {
            def Camera "other" { }
        }
    }
}
)usd";

}  // namespace umax::testing
