// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/open_truth.h"

#include "rastro/base/error.h"

namespace rastro::cli {

OpenedTruth open_truth(const std::string& data_folder) {
  throw Error("there is no surface truth", data_folder, "give a folder written by `rastro simulate`");
}

}  // namespace rastro::cli
