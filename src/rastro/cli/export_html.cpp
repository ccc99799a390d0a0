// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/export_formats.h"
#include "rastro/viewer/page.h"

namespace rastro::cli {

ExportFacts export_html(const ExportJob& job) {
  constexpr std::size_t default_points = 300'000;  // a file to send to a colleague
  const ViewSceneOptions options = scene_options(job.settings.scene, job.settings.cloud.submap, default_points);
  const NamedScene scene = scene_of(job.input, options, job.pool, job.progress);
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
