// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/task_pool.h"
#include "rastro/cli/command.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/dataset/open.h"
#include "rastro/feature/orb.h"
#include "rastro/place/vocabulary.h"

namespace rastro::cli {
namespace {

constexpr const char* footer =
    R"(Learns the words by which places are recognised: a tree of ORB descriptors. One learned on many kinds of generated pictures
comes with rastro and is used without being asked for; one of your own pays where all recordings are of one kind, as under
water. IMAGES are what other commands take as DATA, too: a folder or (quoted) glob of pictures, a recording, a video. The same
pictures and flags give the same bytes, for any number of threads. Pictures that differ teach more than many of one place: use
--every on recordings.

Examples:
  rastro vocabulary pictures/ --out mine.rvoc
  rastro vocabulary MH_01_easy kitti/00 --every 10 --out mine.rvoc
  rastro vocabulary 'frames/*.png' --branching 10 --depth 4 --out small.rvoc)";

struct Flags {
  std::vector<std::string> images;
  std::string out;
  int every = 1, threads = 0;
  OrbOptions features;
  VocabularyOptions tree;
  bool force = false, json = false, quiet = false;
};

using Descriptors = std::vector<std::vector<Descriptor>>;

/// Of every picture of one argument. A picture that cannot be read is said and left out.
void collect(const std::string& path, const Flags& flags, OrbExtractor& extractor, TaskPool& pool, ProgressBar& bar,
             Descriptors& descriptors) {
  OpenOptions options;
  options.every = flags.every;
  const std::unique_ptr<Source> source = rastro::open(path, options);
  if (!source->info().has_image) throw Error("holds no pictures", path, "give recordings of a camera");
  const auto all = static_cast<std::size_t>(std::max<std::int64_t>(0, source->info().frame_count));
  for (std::size_t read = 0;; ++read) {
    try {
      const auto frame = source->next();
      if (!frame) return;
      descriptors.push_back(extractor.extract(frame->image.view(), {}, &pool).descriptors);
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      log_warning(error.what());
    }
    bar.show_steps("pictures", read + 1, std::max(all, read + 1));
  }
}

void refuse_existing(const Flags& flags) {
  if (!flags.force && std::filesystem::exists(flags.out))
    throw Error("already exists", flags.out, "choose another name, or add --force to replace it");
}

void say(const Flags& flags, const Descriptors& descriptors, const Vocabulary& vocabulary) {
  std::size_t count = 0;
  for (const auto& picture : descriptors) count += picture.size();
  const auto bytes = std::filesystem::file_size(flags.out);
  if (flags.json) {
    nlohmann::ordered_json json;
    json["out"] = flags.out;
    json["pictures"] = descriptors.size();
    json["descriptors"] = count;
    json["words"] = vocabulary.words();
    json["branching"] = vocabulary.branching();
    json["depth"] = vocabulary.depth();
    json["bytes"] = bytes;
    fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (!flags.quiet) {
    fmt::print("{} words of {} descriptors of {} pictures written to {} ({:.0f} kB)\n", vocabulary.words(), count,
               descriptors.size(), flags.out, static_cast<double>(bytes) / 1e3);
  }
}

void learn(const Flags& flags) {
  refuse_existing(flags);
  TaskPool pool(flags.threads);
  ProgressBar bar(!flags.quiet);
  OrbExtractor extractor(flags.features);
  Descriptors descriptors;
  for (const std::string& path : flags.images) collect(path, flags, extractor, pool, bar, descriptors);
  const auto vocabulary = Vocabulary::train(descriptors, flags.tree, &pool, [&](double share) {
    bar.show_steps("levels", static_cast<std::size_t>(share * flags.tree.depth + 0.5),
                   static_cast<std::size_t>(flags.tree.depth));
  });
  bar.clear();
  vocabulary.write(flags.out);
  say(flags, descriptors, vocabulary);
}

void add_flags(CLI::App& command, Flags& flags) {
  command.add_option("images", flags.images, "Recordings, folders or globs of pictures, videos")->required();
  command.add_option("--out", flags.out, "File to write; .rvoc by custom")->type_name("FILE")->required();
  command.add_option("--every", flags.every, "Of each argument, take every N-th picture")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command.add_option("--branching", flags.tree.branching, "Children of a node of the tree, 2..64")
      ->capture_default_str();
  command.add_option("--depth", flags.tree.depth, "Levels of the tree, 1..8; there are at most branching^depth words")
      ->capture_default_str();
  command.add_option("--features", flags.features.features, "ORB features a picture")->capture_default_str();
  command.add_option("--levels", flags.features.levels, "Of the image pyramid")->capture_default_str();
  command.add_option("--scale-factor", flags.features.scale_factor, "From one level to the next")
      ->capture_default_str();
  command.add_option("--seed", flags.tree.seed, "Of the first centres")->capture_default_str();
  command.add_option("--threads", flags.threads, "0 = all of the machine; the bytes do not depend on it")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_flag("--force", flags.force, "Replace a file that is already there");
  command.add_flag("--json", flags.json, "Print the summary as JSON");
  command.add_flag("--quiet", flags.quiet, "Print nothing but errors");
}

}  // namespace

void add_vocabulary_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("vocabulary", "Learn from pictures the words by which places are recognised");
  const auto flags = std::make_shared<Flags>();
  add_flags(*command, *flags);
  command->footer(footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    learn(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
