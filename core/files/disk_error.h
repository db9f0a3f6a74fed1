// What the user can do about files that cannot be written, by the system's reason.
#pragma once

#include <cerrno>

namespace umax {

/// Whether there is no room left: on the disk, of the user's share, or for so large a file.
inline bool is_out_of_room(int error) {
  return error == ENOSPC || error == EDQUOT || error == EFBIG;
}

/// The remedy that an error's text tells.
inline const char* disk_remedy(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free some space, then go on with --resume, or choose another disk with -o";
    case EFBIG:
      return "raise the limit on the size of files (ulimit -f), then go on with --resume";
    case EROFS:
      return "the file system is mounted for reading alone: mount it for writing, or choose another with -o";
    case ENOENT:
    case ENODEV:
    case ESTALE:
    case ENOTCONN:
    case EIO:
      return "the folder has vanished or its disk fails: look for it, then go on with --resume";
    default:
      return "choose a folder that can be written with -o";
  }
}

}  // namespace umax
