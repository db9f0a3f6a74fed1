// What runs of one scene with other values are called, by the keys that differ.
#pragma once

#include <string>
#include <vector>

namespace umax {

/// The shortest end of the key, at dots, that no other of these keys ends with: "stretch" of
/// "body.figure.limit.stretch".
std::string short_key(const std::string& key, const std::vector<std::string>& keys);

/// The text as a folder's name that no shell and no file system minds.
std::string folder_name(const std::string& text);

/// A word of a command as a shell reads it back: in quotes where it needs them.
std::string shell_word(const std::string& word);

}  // namespace umax
