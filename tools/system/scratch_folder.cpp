#include "tools/system/scratch_folder.h"

#include <unistd.h>

#include <cstdlib>
#include <string>

#include "core/base/error.h"

namespace umax {

ScratchFolder::ScratchFolder(const std::filesystem::path& place) {
  std::string name = (place / ".umax-scratch-XXXXXX").string();  // mkdtemp() replaces the last six letters
  if (!mkdtemp(name.data()))
    throw Error(Fault::cannot_create, {.where = place.string(),
                                       .what = "takes no new folder",
                                       .remedy = "choose a folder that may be written to; TMPDIR names that of "
                                                 "temporary files"});
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace umax
