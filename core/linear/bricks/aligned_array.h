// A fixed-size array of numbers for vector instructions: it begins on a cache line, is filled with zeros, and stands in
// huge pages where the system has them.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace umax {

template <class T>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size) : size_(size), values_(allocate(size)) {}

  T* data() { return values_.get(); }
  const T* data() const { return values_.get(); }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return values_.get()[i]; }
  const T& operator[](std::size_t i) const { return values_.get()[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }

 private:
  static T* allocate(std::size_t size) {
    constexpr std::size_t cache_line = 64, huge_page = std::size_t(1) << 21;
    const std::size_t bytes = size * sizeof(T);
    const std::size_t alignment = bytes < huge_page ? cache_line : huge_page;
    const std::size_t padded = (bytes + alignment - 1) / alignment * alignment;
    void* memory = std::aligned_alloc(alignment, padded);
    if (!memory && padded > 0) throw std::bad_alloc();
#ifdef __linux__
    if (alignment == huge_page) madvise(memory, padded, MADV_HUGEPAGE);
#endif
    if (memory) std::memset(memory, 0, padded);
    return static_cast<T*>(memory);
  }
  struct Free {
    void operator()(T* memory) const { std::free(memory); }
  };
  std::size_t size_ = 0;
  std::unique_ptr<T, Free> values_;
};

}  // namespace umax
