// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/method_offers.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/methods/methods.h"

namespace rastro::cli {
namespace {

constexpr const char* flag = "--methods";

const Option* option_named(const OptionTable& table, const std::string& name) {
  const auto& options = table.options();
  const auto found =
      std::find_if(options.begin(), options.end(), [&](const Option& each) { return each.name == name; });
  return found == options.end() ? nullptr : &*found;
}

/// Of a method that has no choice of sensors.
template <typename Method>
std::string kind_of(const Method& method) {
  if (method.name() == "auto") return "auto";
  if (method.wants_depth()) return "depth";
  return method.needs().find("laser") != std::string::npos ? "laser" : "mono";
}

/// A method with each of its sensors; "auto" is one of the others.
template <typename Method>
void append_offers(const std::string& command, Method& method, std::vector<MethodOffer>& offers) {
  const OptionTable table = method.options();
  MethodOffer offer{command, method.name(), "", kind_of(method), option_named(table, "seed") != nullptr};
  const Option* sensor = option_named(table, "sensor");
  if (sensor == nullptr) {
    offers.push_back(offer);
    if (offer.method != "hector") return;
    offer.sensor = "scan";
    offers.push_back(offer);
    return;
  }
  for (const std::string& choice : sensor->choices) {
    if (choice == "auto") continue;
    offer.sensor = choice;
    offer.kind = choice == "rgbd" ? "depth" : choice;
    offers.push_back(offer);
  }
}

std::vector<MethodOffer> every_method() {
  std::vector<MethodOffer> offers;
  for (const auto& method : selectable_slam_methods()) append_offers("slam", *method, offers);
  for (const auto& method : odometry_methods()) append_offers("odometry", *method, offers);
  return offers;
}

/// "odometry/rgbd:SENSOR" in parts; a part that is not given is empty.
MethodOffer parsed(const std::string& text) {
  MethodOffer wanted;
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) wanted.sensor = text.substr(colon + 1);
  const std::string name = text.substr(0, colon);
  const std::size_t slash = name.find('/');
  if (slash != std::string::npos) wanted.command = name.substr(0, slash);
  wanted.method = slash == std::string::npos ? name : name.substr(slash + 1);
  return wanted;
}

bool fits(const MethodOffer& offer, const MethodOffer& wanted) {
  return offer.method == wanted.method && (wanted.command.empty() || offer.command == wanted.command) &&
         (wanted.sensor.empty() || offer.sensor == wanted.sensor);
}

/// A name that SLAM and odometry both have is that of SLAM.
void append_fitting(const std::string& text, const std::vector<MethodOffer>& all, std::vector<MethodOffer>& chosen) {
  MethodOffer wanted = parsed(text);
  std::vector<std::string> names;
  for (const MethodOffer& offer : all) {
    if (std::find(names.begin(), names.end(), offer.method) == names.end()) names.push_back(offer.method);
    if (wanted.command.empty() && fits(offer, wanted)) wanted.command = offer.command;
  }
  const std::size_t before = chosen.size();
  for (const MethodOffer& offer : all)
    if (fits(offer, wanted) && std::find(chosen.begin(), chosen.end(), offer) == chosen.end()) chosen.push_back(offer);
  const bool known = std::any_of(all.begin(), all.end(), [&](const MethodOffer& offer) { return fits(offer, wanted); });
  if (chosen.size() == before && !known)
    throw Error(in_quotes(text) + " is not a method", flag, did_you_mean(parsed(text).method, names));
}

template <typename Method, typename Context>
void make_on(const MethodOffer& offer, std::unique_ptr<Method> method, const std::string& path, OpenOptions options,
             const Context& context) {
  OptionTable table = method->options();
  if (!offer.sensor.empty() && !offer.as_scan()) table.set("sensor", offer.sensor, flag);
  options.want_depth = method->wants_depth() || offer.as_scan();
  options.want_right = method->wants_right();
  options.read_ahead = 0;
  SourceInfo info = rastro::open(path, options)->info();
  if (offer.as_scan()) {
    if (!info.has_depth) throw Error("has no depth images to cut scans out of");
    info.has_image = false, info.has_scan = true;
  }
  method->make(info, context);
}

/// Without the recording and what to do.
std::string short_reason(std::string text, const std::string& path) {
  if (text.starts_with(path + ": ")) text = text.substr(path.size() + 2);
  return one_line(text.substr(0, text.find("; ")));
}

/// Why the method cannot run on the recording; empty: it can.
std::string refusal_of(const MethodOffer& offer, const std::string& path, const OpenOptions& options) {
  try {
    if (offer.command == "slam")
      make_on(offer, slam_method(offer.method), path, options, SlamContext{});
    else
      make_on(offer, odometry_method(offer.method), path, options, OdometryContext{});
  } catch (const Error& error) {
    return short_reason(error.what(), path);
  }
  return "";
}

}  // namespace

std::string MethodOffer::name() const {
  const bool is_ambiguous = command == "odometry" && method == "rgbd";
  return method + (sensor.empty() ? "" : " " + sensor) + (is_ambiguous ? " odometry" : "");
}

std::vector<MethodOffer> methods_named(const std::vector<std::string>& wanted) {
  const std::vector<MethodOffer> all = every_method();
  std::vector<MethodOffer> chosen;
  for (const std::string& text : wanted) {
    if (text == "all") return all;
    append_fitting(text, all, chosen);
  }
  if (chosen.empty()) throw Error("names no method", flag, "give all, or names; 'rastro methods' lists them");
  return chosen;
}

MethodOffers offers_for(const std::string& path, const OpenOptions& options, const std::vector<MethodOffer>& methods) {
  rastro::open(path, options);  // what is wrong with the recording itself is an Error
  MethodOffers offers;
  for (const MethodOffer& method : methods) {
    const std::string refusal = refusal_of(method, path, options);
    if (refusal.empty())
      offers.possible.push_back(method);
    else
      offers.refused.push_back(fmt::format("{}: {}", method.name(), refusal));
  }
  return offers;
}

}  // namespace rastro::cli
