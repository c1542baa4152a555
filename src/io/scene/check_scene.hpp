// Checks the facts of a scene without writing or reading it: a scene built in code obeys the rules
// of a scene file. The functions keep no state.
#pragma once

namespace freeplay {

struct Scene;

/// Applies the rules of parse_scene() to the keys of the scene's canonical text (to_toml()), and
/// throws ModelError with the key of the first violation. [run] is not checked, since
/// RunRequest::until may replace the duration.
void check_scene(const Scene& scene);

/// The rules that concern several elements of a scene whose keys are valid. Throws ModelError.
void check_elements_together(const Scene& scene);

}  // namespace freeplay
