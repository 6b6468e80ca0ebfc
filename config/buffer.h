// A fixed-size, uninitialised, cache-line aligned array. Large ones are aligned to, and ask the
// kernel for, huge pages: page faults on fresh memory otherwise cost more than decoding does.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

namespace kinemesh {

namespace detail {
/// Throws std::bad_alloc. `bytes` may be 0.
void* allocate_buffer(std::size_t bytes);
void release_buffer(void* memory) noexcept;
struct BufferRelease {
  void operator()(void* memory) const noexcept { release_buffer(memory); }
};
}  // namespace detail

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  /// Uninitialised: every element must be written before it is read.
  explicit Buffer(std::size_t size)
      : data_(static_cast<T*>(detail::allocate_buffer(size * sizeof(T)))), size_(size) {}
  Buffer(std::size_t size, T value) : Buffer(size) { std::fill_n(data(), size, value); }
  Buffer(const Buffer& other) : Buffer(other.size_) { std::copy_n(other.data(), size_, data()); }
  Buffer(Buffer&& other) noexcept
      : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)) {}
  Buffer& operator=(Buffer other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~Buffer() = default;

  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  T* data() noexcept { return data_.get(); }
  const T* data() const noexcept { return data_.get(); }
  T& operator[](std::size_t i) noexcept { return data_[i]; }
  const T& operator[](std::size_t i) const noexcept { return data_[i]; }
  T* begin() noexcept { return data(); }
  T* end() noexcept { return data() + size_; }
  const T* begin() const noexcept { return data(); }
  const T* end() const noexcept { return data() + size_; }
  std::span<T> span() noexcept { return {data(), size_}; }
  std::span<const T> span() const noexcept { return {data(), size_}; }

 private:
  std::unique_ptr<T[], detail::BufferRelease> data_;
  std::size_t size_ = 0;
};

}  // namespace kinemesh
