// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/output_folder.h"

#include "cli/findings_file.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <fstream>
#include <string_view>
#include <system_error>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

/** The files directly in a folder, sorted, without hidden ones. */
std::vector<fs::path> visibleFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code broken;  // a link without a target is a file
    if (entry.path().filename().string().front() != '.' && !entry.is_directory(broken))
      files.push_back(entry.path());
  }
  if (error) throw IoError(folder.string(), "cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

/** Is a file a picture, as one that the tools draw may be? A PNG of 16 bits is a depth image or labels. */
bool isPicture(const fs::path& path) {
  constexpr int kPictureBits = 8;
  const auto size = pngSize(path);
  return size && size->bits == kPictureBits;
}

/** Is it a page that was written for a browser (pages/)? */
bool isPage(const fs::path& path) {
  std::array<char, 1000> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  return std::string_view(head.data(), head.size()).find(R"(name="generator" content="facetloc")") !=
         std::string_view::npos;
}

[[noreturn]] void refuse(const fs::path& folder, const fs::path& file) {
  throw IoError(folder.string(),
                fmt::format("holds other files already, such as {}; give --overwrite to write among them, or "
                            "use another folder",
                            file.filename().string()));
}

}  // namespace

const std::vector<std::string>& marksOfResults() {
  static const std::vector<std::string> marks = {"hypotheses.csv", "timing.csv", kFindingsFile};
  return marks;
}

void addOverwrite(CommandLine& line, bool& overwrite) {
  line.addSwitch("overwrite", overwrite, "Write to a folder that already holds other files.");
}

void claimFolder(const fs::path& folder, const std::vector<std::string>& marks, bool overwrite,
                 const Console* console) {
  createFolders(folder);
  if (overwrite) return;
  const std::vector<fs::path> files = visibleFiles(folder);
  const bool is_own = std::any_of(files.begin(), files.end(), [&](const fs::path& file) {
    return std::find(marks.begin(), marks.end(), file.filename().string()) != marks.end();
  });
  if (!files.empty() && !is_own) refuse(folder, files.front());
  if (is_own && console) console->note("the files of an earlier run in " + folder.string() + " are replaced");
}

void claimPictureFolder(const fs::path& folder, bool overwrite) {
  createFolders(folder);
  if (overwrite) return;
  for (const fs::path& file : visibleFiles(folder))
    if (!isPicture(file)) refuse(folder, file);
}

void requireReplaceable(const fs::path& path) {
  if (fs::exists(path) && !isPicture(path) && !isPage(path))
    throw UsageError(fmt::format(
        "the output would overwrite {}, which is neither a picture nor a page of facetloc", path.string()));
}

}  // namespace facetloc
