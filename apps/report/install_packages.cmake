# npm ci, where the lock file is newer than what is there (npm writes a list of that last).
#   cmake -DNPM=… -DSTAMP=FILE -P install_packages.cmake     in the folder of package.json
set(list node_modules/.package-lock.json)
if(NOT EXISTS ${list} OR package-lock.json IS_NEWER_THAN ${list})
  execute_process(COMMAND ${NPM} ci --silent --no-audit --no-fund --ignore-scripts
    RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "npm ci failed in apps/report: the page for reports needs its packages. "
      "Configure with -DDEFORM_BUILD_REPORT=OFF to build without the page.")
  endif()
  file(TOUCH ${list})
endif()
file(TOUCH ${STAMP})
