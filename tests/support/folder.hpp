#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace support {

/// A folder of its own for each test, gone with it.
struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("dragcore_test_" + std::to_string(std::random_device{}()));
  Folder() { std::filesystem::create_directories(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path / name, std::ios::binary) << bytes;
    return path / name;
  }
};

}  // namespace support
