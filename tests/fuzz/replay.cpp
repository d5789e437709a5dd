#include <algorithm>
#include <iterator>
#include <vector>

#include "fuzz.hpp"

/// Gives every file of the folders named as arguments to the fuzz target this is linked with, once each, in the order of their names.
int main(int argc, char** argv) {
  std::vector<std::filesystem::path> files;
  for (int i = 1; i < argc; ++i)
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::printf("%s\n", file.c_str());
    std::fflush(stdout);  // the last name is the culprit's
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    fuzz::check(!in.bad(), "a file of the corpus can be read");
    // Copied to its exact size, so that a sanitizer sees the first byte too far.
    const std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
    LLVMFuzzerTestOneInput(data.data(), data.size());
  }
  std::printf("%zu files, all clean\n", files.size());
  return files.empty() ? 1 : 0;  // a corpus that is not there tests nothing
}
