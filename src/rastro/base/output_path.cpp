// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/output_path.h"

#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_to_make(const fs::path& path, const std::string& reason) {
  throw Error("cannot be made (" + reason + ")", path.string(), "choose another --out");
}

}  // namespace

void refuse_existing(const fs::path& out, bool overwrite) {
  std::error_code code;
  const fs::file_status status = fs::status(out, code);
  if (status.type() == fs::file_type::none) refuse_to_make(out, code.message());
  if (fs::exists(status) && !overwrite)
    throw Error("already exists", out.string(), "choose another --out or add --force");
}

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code code;
  made_ = fs::create_directories(folder_, code);
  // An existing file is no error of create_directories() in every version of the library.
  if (!code && !fs::is_directory(folder_, code) && !code) code = std::make_error_code(std::errc::not_a_directory);
  if (code) refuse_to_make(folder_, code.message());
  if (::access(folder_.c_str(), W_OK | X_OK) != 0)
    throw Error("cannot be written to (" + std::generic_category().message(errno) + ")", folder_.string(),
                "choose another --out");
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (made_) fs::remove(folder_, ignored);  // which leaves one alone that is not empty
}

}  // namespace rastro
