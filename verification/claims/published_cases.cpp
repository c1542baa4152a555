// Published cases of other programs, each with an independent reference. The cases stand in
// cases/published with their sources; the parts are in published_*.cpp.
#include "verification/claims/claim.hpp"

namespace freeplay::verification {

Findings published_cases() {
  Findings f;
  published_smooth(f);
  published_impacts(f);
  published_contacts(f);
  return f;
}

}  // namespace freeplay::verification
