// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace rastro {

/// Collects what libraries written in C (libpng, libjpeg) print on `stderr` from this thread while it lives, after the
/// program has called divert_library_output(). What other threads print is not touched.
class LibraryOutput {
 public:
  LibraryOutput();
  ~LibraryOutput();
  LibraryOutput(const LibraryOutput&) = delete;
  LibraryOutput& operator=(const LibraryOutput&) = delete;

  /// Of this thread so far.
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::string* outer_;
};

/// Makes `stderr` a stream that asks each thread where its text goes; for the start of the program, once. Does nothing
/// with C libraries other than glibc, which cannot.
void divert_library_output();

}  // namespace rastro
