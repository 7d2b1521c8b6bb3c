// A file system of its own that is quickly full.
#pragma once

#include <sys/mount.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

namespace dadrl {

// A tmpfs of `size` ("1m"), mounted at a folder that is made for it. Only root may mount one: see mounted().
class SmallDisk {
 public:
  SmallDisk(std::filesystem::path at, const std::string& size) : path_(std::move(at)) {
    std::filesystem::create_directories(path_);
    mounted_ = mount("tmpfs", path_.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
    error_ = errno;
  }
  ~SmallDisk() {
    if (mounted_) umount2(path_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool mounted() const { return mounted_; }
  std::string why() const { return std::strerror(error_); }
  const std::filesystem::path& path() const { return path_; }

  // Until not a byte is free.
  void Fill() const {
    std::ofstream filler(Filler(), std::ios::binary | std::ios::app);
    for (size_t piece = 1 << 16; piece > 0; piece /= 2) {
      while (filler.write(std::string(piece, 'x').data(), static_cast<std::streamsize>(piece)).flush()) {
      }
      filler.clear();
    }
  }
  // What Fill took is free again.
  void Free() const { std::filesystem::remove(Filler()); }
  // Fails while a file there is open for writing.
  bool MakeReadOnly() const {
    return mount(nullptr, path_.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) == 0;
  }

 private:
  std::filesystem::path Filler() const { return path_ / "filler"; }

  std::filesystem::path path_;
  bool mounted_ = false;
  int error_ = 0;
};

}  // namespace dadrl
