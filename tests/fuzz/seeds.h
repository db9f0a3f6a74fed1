// Small sound inputs of every kind that fuzzing begins with, made by what writes such files.
#pragma once

#include <string>
#include <vector>

namespace umax::fuzz {

struct Seed {
  std::string target;  // "mesh": of read_mesh()
  std::string name;    // of its file
  std::string bytes;
};

std::vector<Seed> seeds();

}  // namespace umax::fuzz
