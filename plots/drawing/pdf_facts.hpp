// Facts of a PDF file: title, subject, keywords and program in its document information dictionary
// (ISO 32000-1, 14.3.3), where pdfinfo and viewers show them.
#pragma once

#include <string>

namespace freeplay::plots {

/// Texts in UTF-8; empty ones are omitted.
struct PdfFacts {
  std::string title, subject, keywords, creator;
};

/// The file with the facts, added by an incremental update (ISO 32000-1, 7.5.6). A file without a
/// cross-reference table at its end, which other versions of cairo may write, is returned as it is.
std::string with_facts(const std::string& pdf, const PdfFacts& facts);

}  // namespace freeplay::plots
