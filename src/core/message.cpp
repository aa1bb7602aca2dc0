#include "core/message.h"

#include "core/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <span>

namespace sightline {

void secure_standard_streams() {
    // open returns the lowest descriptor that is free.
    for (int fd = 0; fd >= 0 && fd <= STDERR_FILENO;) {
        fd = open("/dev/null", O_RDWR);
        if (fd > STDERR_FILENO) close(fd);
    }
    std::signal(SIGPIPE, SIG_IGN);
}

void write_message(std::string_view text) {
    write_all(STDERR_FILENO, std::as_bytes(std::span(text)));
}

}  // namespace sightline
