// Tables of docs/verification/verification.md: the claims of a set by subject, a row for each
// quantity and a column for each scheme.
#pragma once

#include <string>
#include <vector>

#include "verification/claims/claim.hpp"

namespace freeplay::verification {

/// The parts of a claim's name, "subject: quantity [scheme]" (claim_name()).
struct NameParts {
  std::string subject, quantity, scheme;
};
NameParts parts_of(const Claim& c);

/// A heading and a Markdown table for each subject, in the order of their first claims.
std::string tables_by_subject(const std::vector<Claim>& claims);

}  // namespace freeplay::verification
