#include "options.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/localization/landmark_tracking_options.hpp"
#include "loopstone/localization/localization_options.hpp"
#include "loopstone/pipeline/log_landmarks.hpp"
#include "loopstone/registration/align_options.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/slam/map_options.hpp"

namespace loopstone::python {

namespace {

nb::str text(std::string_view word) { return nb::str(word.data(), word.size()); }

nb::object value_of(const OptionEntry& entry) {
  return std::visit(
      [](const auto& field) -> nb::object {
        if constexpr (std::is_same_v<std::decay_t<decltype(field)>, WordField>) {
          return text(*field);
        } else {
          return nb::cast(*field);
        }
      },
      entry.value);
}

nb::list words_of_entry(const OptionEntry& entry) {
  nb::list words;
  if (const auto* field = std::get_if<WordField>(&entry.value)) {
    for (const std::string_view word : field->words()) words.append(text(word));
  }
  return words;
}

template <typename Options>
nb::list describe() {
  Options options;
  nb::list entries;
  for (const OptionEntry& entry : list_options(options)) {
    nb::dict described;
    described["key"] = entry.key;
    described["default"] = value_of(entry);
    described["words"] = words_of_entry(entry);
    described["range"] = entry.range
                             ? nb::object(nb::make_tuple(entry.range->lowest, entry.range->highest))
                             : nb::none();
    described["rule"] = rule_of(entry);
    described["help"] = entry.help;
    entries.append(described);
  }
  return entries;
}

/// The options of a call by its name.
nb::list describe_options(const std::string& of) {
  if (of == "map") return describe<MapOptions>();
  if (of == "landmark_map") return describe<LandmarkMapOptions>();
  if (of == "localize") return describe<LocalizationOptions>();
  if (of == "landmarks") return describe<LandmarkTrackingOptions>();
  if (of == "match") return describe<AlignOptions<2>>();
  if (of == "match_3d") return describe<AlignOptions<3>>();
  if (of == "optimize") return describe<OptimizeOptions>();
  if (of == "simulate") return describe<SimulationOptions>();
  throw UsageError("there are no options of '" + of + "'");
}

template <typename Options>
std::string toml(const OptionValues& given) {
  auto options = options_of<Options>(given);
  return options_to_toml(list_options(options));
}

std::string options_text(const std::string& of, const OptionValues& given) {
  if (of == "map") return toml<MapOptions>(given);
  if (of == "landmark_map") return toml<LandmarkMapOptions>(given);
  if (of == "localize") return toml<LocalizationOptions>(given);
  if (of == "landmarks") return toml<LandmarkTrackingOptions>(given);
  if (of == "match") return toml<AlignOptions<2>>(given);
  if (of == "match_3d") return toml<AlignOptions<3>>(given);
  if (of == "optimize") return toml<OptimizeOptions>(given);
  if (of == "simulate") return toml<SimulationOptions>(given);
  throw UsageError("there are no options of '" + of + "'");
}

}  // namespace

void set_options(const std::vector<OptionEntry>& options, const OptionValues& given) {
  std::vector<OptionProblem> problems;
  if (!given.file.empty()) problems = apply_options_file(options, given.file);
  for (const auto& [key, value] : given.values) {
    std::string assignment = key;
    assignment.append("=").append(value);
    for (OptionProblem& problem : apply_assignment(options, assignment)) {
      problem.where.path = "options";
      problems.push_back(std::move(problem));
    }
  }
  if (!problems.empty()) throw OptionsError(std::move(problems));
}

void bind_options(nb::module_& m) {
  nb::class_<OptionValues> values(
      m, "OptionValues", "What is to be other than by default; loopstone.options makes it.");
  values.def(
      "__init__",
      [](OptionValues* self, const std::string& file,
         std::vector<std::pair<std::string, std::string>> given) {
        new (self) OptionValues{file, std::move(given)};
      },
      nb::arg("file") = "", nb::arg("values") = std::vector<std::pair<std::string, std::string>>{});
  m.def("describe_options", describe_options, nb::arg("of"),
        nb::sig("def describe_options(of: str) -> list[dict[str, typing.Any]]"),
        "Every option of a call: its dotted key, default, words, range, rule and help.");
  m.def("options_toml", options_text, nb::arg("of"), nb::arg("values"),
        "The effective options as TOML, as `loopstone config` prints them. Raises OptionsError.");
}

}  // namespace loopstone::python
