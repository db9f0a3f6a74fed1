// The pages: links, anchors and files that they name are there, each is linked from the README, which is short.
#include <algorithm>
#include <regex>
#include <set>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

const fs::path root = UMAX_SOURCE_DIR;

std::vector<fs::path> files_of(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == extension) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// README.md, CONTRIBUTING.md, CHANGELOG.md and docs/*.md.
std::vector<fs::path> pages() {
  std::vector<fs::path> all = files_of(root, ".md");
  for (const fs::path& page : files_of(root / "docs", ".md")) all.push_back(page);
  return all;
}

/// The page without its blocks of code.
std::string prose_of(const fs::path& page) {
  static const std::regex block("```[^`]*```");
  return std::regex_replace(file_text(page), block, "");
}

/// What follows the pattern's first group, for each match.
std::vector<std::string> all_matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
    found.push_back((*match)[1]);
  return found;
}

std::vector<std::string> headings_of(const fs::path& page) {
  static const std::regex heading("(?:^|\n)#+ ([^\n]+)");
  return all_matches(prose_of(page), heading);
}

/// "What it holds to" -> "what-it-holds-to", as GitHub makes anchors: of ASCII, letters, digits, - and _ stay.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ')
      anchor += '-';
    else if (byte >= 0x80 || std::isalnum(byte) || c == '-' || c == '_')
      anchor += char(std::tolower(byte));
  }
  return anchor;
}

bool has_anchor(const fs::path& page, const std::string& anchor) {
  const std::vector<std::string> headings = headings_of(page);
  return std::any_of(headings.begin(), headings.end(),
                     [&](const std::string& heading) { return anchor_of(heading) == anchor; });
}

struct Link {
  fs::path file;  // absolute; a link within a page: the page
  std::string anchor;
};

/// Links and pictures of a page that lead to files of the project.
std::vector<Link> links_of(const fs::path& page) {
  static const std::regex pattern("\\]\\(([^)]+)\\)");
  std::vector<Link> links;
  for (const std::string& target : all_matches(prose_of(page), pattern)) {
    if (target.find("://") != std::string::npos) continue;
    const std::size_t hash = std::min(target.find('#'), target.size());
    const std::string file = target.substr(0, hash);
    links.push_back({file.empty() ? page : (page.parent_path() / file).lexically_normal(),
                     target.substr(std::min(hash + 1, target.size()))});
  }
  return links;
}

}  // namespace

TEST_CASE("anchors are those that GitHub makes") {
  CHECK(anchor_of("What it holds to") == "what-it-holds-to");
  CHECK(anchor_of("`[body.NAME]`") == "bodyname");
  CHECK(anchor_of("steps.csv") == "stepscsv");
  CHECK(anchor_of("Stretch 15 % and no more") == "stretch-15--and-no-more");
}

TEST_CASE("every link of the pages leads to a file that is there, and every anchor to a heading") {
  int num_links = 0, num_anchors = 0;
  for (const fs::path& page : pages())
    for (const Link& link : links_of(page)) {
      CAPTURE(page, link.file, link.anchor);
      CHECK(fs::exists(link.file));
      ++num_links;
      if (link.anchor.empty() || link.file.extension() != ".md") continue;
      CHECK(has_anchor(link.file, link.anchor));
      ++num_anchors;
    }
  CHECK(num_links > 60);
  CHECK(num_anchors > 25);
}

TEST_CASE("headings of a page differ, so that each can be linked to") {
  for (const fs::path& page : pages()) {
    std::set<std::string> anchors;
    for (const std::string& heading : headings_of(page)) {
      CAPTURE(page, heading);
      CHECK(anchors.insert(anchor_of(heading)).second);
    }
    CHECK(anchors.size() >= 2);
  }
}

TEST_CASE("the README is a page of 10 kB at most that links to every other one") {
  const fs::path readme = root / "README.md";
  CHECK(fs::file_size(readme) <= 10'000);
  std::set<fs::path> linked{readme};
  for (const Link& link : links_of(readme)) linked.insert(link.file);
  for (const fs::path& page : pages()) {
    CAPTURE(page);
    CHECK(linked.count(page) == 1);
  }
}

TEST_CASE("every picture in docs is shown in the gallery") {
  std::set<fs::path> shown;
  for (const Link& link : links_of(root / "docs/gallery.md")) shown.insert(link.file);
  for (const char* kind : {".png", ".webp"})
    for (const fs::path& picture : files_of(root / "docs", kind)) {
      CAPTURE(picture);
      CHECK(shown.count(picture) == 1);
    }
}

TEST_CASE("files and folders of the project that pages name are there") {
  static const std::regex name("`((?:core|embedding|render|scenes|tools|tests|cmake|docs)/[A-Za-z0-9_./-]*)`");
  int num_names = 0;
  for (const fs::path& page : pages())
    for (const std::string& path : all_matches(prose_of(page), name)) {
      CAPTURE(page, path);
      if (path.find("NAME") != std::string::npos) continue;
      CHECK(fs::exists(root / path));
      ++num_names;
    }
  CHECK(num_names > 60);
}

TEST_CASE("the page on architecture names every room") {
  const std::string page = file_text(root / "docs/architecture.md");
  int num_rooms = 0;
  for (const char* top : {"core", "embedding", "render", "scenes", "tools"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.path().filename() != "CMakeLists.txt") continue;
      if (file_text(entry.path()).find("umax_room(") == std::string::npos) continue;
      const std::string room = fs::relative(entry.path().parent_path(), root).generic_string();
      CAPTURE(room);
      CHECK(page.find("| `" + room + "` |") != std::string::npos);
      ++num_rooms;
    }
  CHECK(num_rooms > 30);
}

TEST_CASE("what sources cite of a page is a heading of it") {
  static const std::regex citation("docs/([a-z_]+\\.md), ([^\n]+)");
  const std::string old_notes = std::string("THE") + "ORY";  // citations of what is no part of the project
  int num_citations = 0;
  for (const char* top : {"core", "embedding", "render", "scenes", "tools", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const fs::path extension = entry.path().extension();
      if ((extension != ".h" && extension != ".cpp") || entry.path().filename() == "test_docs.cpp") continue;
      const std::string text = file_text(entry.path());
      CAPTURE(entry.path());
      CHECK(text.find(old_notes) == std::string::npos);
      for (std::sregex_iterator match(text.begin(), text.end(), citation), end; match != end; ++match) {
        const fs::path page = root / "docs" / (*match)[1].str();
        const std::string words = (*match)[2];  // a heading, and what follows it
        CAPTURE(page, words);
        const std::vector<std::string> headings = headings_of(page);
        CHECK(std::any_of(headings.begin(), headings.end(), [&](const std::string& heading) {
          return words.starts_with(heading) &&
                 (words.size() == heading.size() || !std::isalnum(static_cast<unsigned char>(words[heading.size()])));
        }));
        ++num_citations;
      }
    }
  CHECK(num_citations >= 3);
}
