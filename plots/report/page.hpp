// One page for a browser: page/page.html with its style, its script and the data, no file and no address beside it.
//
// Texts of a page are data to it. They stand in one block of JSON in which <, >, & and the line separators of JavaScript are spelt
// as \u003c, ..., so that nothing in them ends the block; the script shows them as text only. And should one get further,
// the page's policy lets no script and no style run but those two whose SHA-256 it names, and reaches nothing.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace freeplay::report {

/// A document as the text of an element <script type="application/json">.
std::string embedded(const nlohmann::json& document);

/// Text as the content of an element, or of an attribute in quotes.
std::string html_text(std::string_view text);

/// The page that shows a document, called `title`.
std::string page(const std::string& title, const nlohmann::json& document);

}  // namespace freeplay::report
