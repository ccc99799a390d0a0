// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/cli/export_formats.h"
#include "rastro/viewer/page.h"

namespace rastro::cli {

ExportFacts export_html(const ExportJob& job) {
  constexpr std::size_t default_points = 300'000;  // a file to send to a colleague
  const ViewSceneOptions options = scene_options(job.settings.scene, job.settings.cloud.submap, default_points);
  const NamedScene scene = scene_of(job.input, options, job.pool, job.progress, job.settings.scene.objects);
  // As base64 just below the longest text that browsers hold (2^29 letters).
  constexpr std::size_t most_bytes = 390'000'000;
  if (scene.bytes.size() > most_bytes)
    throw Error(fmt::format("has {} MB to show, and browsers open files of at most {}", scene.bytes.size() / 1'000'000,
                            most_bytes / 1'000'000),
                job.input.path, "give fewer --points, or use 'rastro view'");
  std::size_t bytes = 0;
  write_export(job.settings.out, [&](const PutPiece& put) {
    put_page_with_scenes({&scene, 1}, [&](std::string_view piece) {
      put(piece);
      bytes += piece.size();
    });
  });
  return {{"bytes", bytes}};
}

}  // namespace rastro::cli
