#pragma once

namespace deform::app {

/// The commit of the sources, "-dirty" behind it where files were changed since; "" where nobody
/// knows it: the sources were no repository of git.
[[nodiscard]] const char* commit();

}  // namespace deform::app
