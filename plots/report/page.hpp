// A self-contained page for a browser: page/page.html with its style, its script and the data. It
// refers to no other file and no address.
//
// All texts of a page are data in one block of JSON. There <, >, & and the line separators of
// JavaScript are written as \u003c, ..., so that no text can end the block; the script shows them
// as text only. As a second protection the content security policy of the page permits only its own
// script and style, by their SHA-256, and no connections.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace freeplay::report {

/// A document as the content of an element <script type="application/json">.
std::string embedded(const nlohmann::json& document);

/// Text escaped as the content of an element or of an attribute in quotes.
std::string html_text(std::string_view text);

/// Bytes in base 64 (RFC 4648).
std::string base64(std::string_view bytes);

/// The page of a document, with this title.
std::string page(const std::string& title, const nlohmann::json& document);

}  // namespace freeplay::report
