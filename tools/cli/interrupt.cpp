#include "interrupt.h"

#include "core/message.h"

#include <unistd.h>

#include <csignal>
#include <thread>

namespace sightline {

std::stop_source stop_on_signals(std::optional<std::chrono::milliseconds> limit) {
    std::stop_source source;
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread([source, signals, limit]() mutable {
        int signal = 0;
        sigwait(&signals, &signal);
        source.request_stop();
        pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
        // The next signal comes to this thread, the only one that takes any.
        while (!limit) ::pause();
        std::this_thread::sleep_for(*limit);
        write_message("sightline: interrupted; what was not written yet is discarded\n");
        _exit(1);
    }).detach();
    return source;
}

}  // namespace sightline
