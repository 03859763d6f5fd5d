# Writes FILE, which knows the commit of the sources in SOURCE_DIR; leaves it alone where that has not changed, so
# that nothing is compiled again. Run by every build: a commit is not seen when the project is configured.
cmake_minimum_required(VERSION 3.25)
set(commit "")
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE_DIR} describe --always --dirty --abbrev=40 --exclude=*
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(failed)
    set(commit "")
  endif()
endif()
file(CONFIGURE OUTPUT ${FILE} CONTENT "\
#include \"commit.h\"

namespace deform::app {

const char* commit() { return \"${commit}\"; }

}  // namespace deform::app
" @ONLY)
