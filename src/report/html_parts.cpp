#include "report/html_parts.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "report/report_style.hpp"
#include "report/text.hpp"

namespace loopstone {

std::string html_key_table(const std::string& caption, const std::vector<HtmlRow>& rows) {
  std::string html = "<table class=\"key\"><caption>" + caption + "</caption>\n";
  for (const HtmlRow& row : rows) {
    html +=
        "<tr><th scope=\"row\">" + row.name + "</th><td class=\"n\">" + row.value + "</td></tr>\n";
  }
  return html + "</table>\n";
}

std::string count_of(std::int64_t count, const std::string& one, const std::string& many) {
  return with_thousands(count) + " " + (count == 1 ? one : many);
}

std::string log_name(const RunInfo& info) {
  std::filesystem::path path(info.log_path);
  if (!path.has_filename()) path = path.parent_path();  // a folder given with a slash at its end
  return path.filename().empty() ? "a log" : path.filename().string();
}

std::string html_warnings(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return "<p class=\"good\">No warnings.</p>\n";
  std::string html = "<div class=\"warnings\"><strong>" +
                     count_of(static_cast<std::int64_t>(warnings.size()), "warning", "warnings") +
                     "</strong>\n<ul>\n";
  for (const std::string& warning : warnings) html += "<li>" + escape_html(warning) + "</li>\n";
  return html + "</ul></div>\n";
}

std::string html_figure(const std::string& content, const std::string& caption) {
  if (content.empty()) return {};
  return "<figure>\n" + content + "<figcaption>" + caption + "</figcaption></figure>\n";
}

std::string html_picture(std::string_view png, std::string_view css_class,
                         std::string_view alternative_text) {
  return fmt::format("<img class=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\">", css_class,
                     escape_html(alternative_text), base64(png));
}

std::string html_options(const RunInfo& info) {
  return "<h2>Options</h2>\n<details><summary>The effective options of this "
         "run</summary>\n<pre>" +
         escape_html(info.options_toml) + "</pre></details>\n";
}

std::string html_file_list(const std::vector<ListedFile>& files) {
  std::string html = "<h2>Files</h2>\n<div class=\"scroll\"><table class=\"list\"><tbody>\n";
  html += "<tr><td><code>report.html</code></td><td>this page</td><td></td></tr>\n";
  for (const ListedFile& file : files) {
    html +=
        fmt::format("<tr><td><code>{}</code></td><td>{}</td><td class=\"n\">{}</td></tr>\n",
                    escape_html(file.name), escape_html(file.content), readable_bytes(file.bytes));
  }
  return html + "</tbody></table></div>\n";
}

std::string html_page(const std::string& title_text, const std::string& body, const RunInfo& info) {
  const std::string title = escape_html(title_text);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      title + "</title>\n<style>" + std::string(kReportStyle) + "</style></head><body>\n";
  html += "<h1>" + title + "</h1>\n" + body;
  html += "<p class=\"soft\">Loopstone " + escape_html(info.version) + ", log " +
          escape_html(info.log_path);
  if (!info.command_line.empty()) html += "<br><code>" + escape_html(info.command_line) + "</code>";
  return html + "</p>\n</body></html>\n";
}

}  // namespace loopstone
