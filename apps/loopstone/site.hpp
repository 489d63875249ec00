#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <span>
#include <string>

#include "app.hpp"
#include "loopstone/pipeline/site.hpp"
#include "result.hpp"

// `loopstone site`: its commands, each in a file of its own.

namespace loopstone::app {

void add_site_add_command(CLI::App& site, AppContext& context);
void add_site_map_commands(CLI::App& site, AppContext& context);
void add_site_show_commands(CLI::App& site, AppContext& context);
void add_site_edit_commands(CLI::App& site, AppContext& context);
void add_site_care_commands(CLI::App& site, AppContext& context);

/// Says once that another program writes the site; Ctrl-C ends the waiting and the search.
[[nodiscard]] SiteWatch site_watch(const AppContext& context);

/// What a flag says of a day or a moment. Throws UsageError when it is none.
/// \param parse  or parse_utc_end
[[nodiscard]] Stamp read_date(const std::string& flag, const std::string& text,
                              std::optional<Stamp> (*parse)(const std::string&) = parse_utc);

[[nodiscard]] nlohmann::ordered_json json_of(const SiteSession& session);
[[nodiscard]] nlohmann::ordered_json json_of(std::span<const SiteCorrection> edits);

}  // namespace loopstone::app
