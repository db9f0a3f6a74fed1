// fuzz_seeds FOLDER: writes FOLDER/TARGET/NAME, what fuzzing begins with.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/seeds.h"

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds FOLDER\n");
    return 2;
  }
  for (const umax::fuzz::Seed& seed : umax::fuzz::seeds()) {
    const auto folder = std::filesystem::path(words[1]) / seed.target;
    std::filesystem::create_directories(folder);
    std::ofstream(folder / seed.name, std::ios::binary) << seed.bytes;
  }
  return 0;
}
