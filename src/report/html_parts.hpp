#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/report/run_info.hpp"
#include "report/output_files.hpp"

// Pieces that every report is put together from. What is called html is put in as it is, what is
// called text is escaped.

namespace loopstone {

/// A figure with its name; both html.
struct HtmlRow {
  std::string name;
  std::string value;
};

[[nodiscard]] std::string html_key_table(const std::string& caption,
                                         const std::vector<HtmlRow>& rows);

/// "1 scan", "6,256 scans".
[[nodiscard]] std::string count_of(std::int64_t count, const std::string& one,
                                   const std::string& many);

/// The last part of a log's path, as text; "a log" when there is none.
[[nodiscard]] std::string log_name(const RunInfo& info);

/// A box with one text a line, or that there are none.
[[nodiscard]] std::string html_warnings(const std::vector<std::string>& warnings);

/// Empty when the content is.
[[nodiscard]] std::string html_figure(const std::string& content, const std::string& caption);

/// An <img> that carries its picture along.
[[nodiscard]] std::string html_picture(std::string_view png, std::string_view css_class,
                                       std::string_view alternative_text);

[[nodiscard]] std::string html_options(const RunInfo& info);
[[nodiscard]] std::string html_file_list(const std::vector<ListedFile>& files);

/// The whole page: head, title, body, and at its foot who made it from what.
[[nodiscard]] std::string html_page(const std::string& title_text, const std::string& body,
                                    const RunInfo& info);

}  // namespace loopstone
