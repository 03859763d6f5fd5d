#include "terminal.h"

#include <cstdio>
#include <fcntl.h>
#include <unistd.h>

namespace deform::app {

void put_result(std::string_view text) { (void)std::fwrite(text.data(), 1, text.size(), stdout); }

void put_message(std::string_view text) {
  (void)std::fwrite(text.data(), 1, text.size(), stderr);
  (void)std::fflush(stderr);
}

void put_lines(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    put_result(printable(text.substr(0, end)));
    if (end == std::string_view::npos) return;
    put_result("\n");
    text.remove_prefix(end + 1);
  }
}

void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    // The wrong way round: whoever uses it hears that it is not there. The lowest free number is
    // the one that is closed.
    (void)::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

}  // namespace deform::app
