// A display that nobody sees, for tests of windows and engines.
#pragma once

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "catch.hpp"
#include "support/temporary_directory.hpp"

namespace farfield::test {

/// An X server of this test alone, which answers from the constructor's end to the destructor's. Its number is this
/// process', not the first that is free: a server on its way out takes the socket of its number with it, be it that of
/// whoever came after. (xvfb-run fails at times for that, and for what it cannot clean up.)
class Display {
  public:
    Display() {
        constexpr int servers = 20, first = 100, numbers = 50'000;
        for (int i = 0; i < servers; ++i) {
            number_ = first + (getpid() + i * 7919) % numbers;
            if (answers_soon()) return;
            stop();
        }
        throw std::runtime_error("Xvfb starts and does not answer: none of " + std::to_string(servers) + " tries");
    }
    ~Display() { stop(); }
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;

    /// Null where there is no Xvfb, and the test says so. Programs that this one runs use it.
    static std::unique_ptr<Display> open() {
        if (std::system("command -v Xvfb >/dev/null 2>&1") != 0) {
            WARN("skipped: Xvfb is not there");
            return nullptr;
        }
        auto display = std::make_unique<Display>();
        setenv("DISPLAY", display->name().c_str(), 1);
        setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
        unsetenv("WAYLAND_DISPLAY");
        return display;
    }

    std::string name() const { return ":" + std::to_string(number_); }

  private:
    bool answers_soon() {
        process_ = fork();
        if (process_ == 0) {
            prctl(PR_SET_PDEATHSIG, SIGTERM);  // however this program ends
            const int said = ::open((directory_ / "said").c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0644);
            dup2(said, STDOUT_FILENO);
            dup2(said, STDERR_FILENO);
            // It must not end with its last client: the next one is the same test's.
            execlp("Xvfb", "Xvfb", name().c_str(), "-screen", "0", "1280x1024x24", "-noreset", "-nolisten", "tcp",
                   static_cast<char*>(nullptr));
            _exit(127);
        }
        for (int i = 0; process_ > 0 && i < 600; ++i) {
            if (answers()) return true;
            if (waitpid(process_, nullptr, WNOHANG) == process_) process_ = 0;  // the number is taken
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        return false;
    }

    /// As a client begins: the least that may be asked, which a server either grants (1) or not. By a socket in the
    /// file system or, where the server may not make one there, by its abstract name.
    bool answers() const {
        const std::string path = "/tmp/.X11-unix/X" + std::to_string(number_);
        return answers_at(path) || answers_at(std::string(1, 0) + path);
    }
    static bool answers_at(const std::string& path) {
        const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        const auto size = socklen_t(offsetof(sockaddr_un, sun_path) + path.size());
        const std::array<char, 12> hello{'l', 0, 11};
        char granted = 0;
        const bool did = connect(socket, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                         send(socket, hello.data(), hello.size(), MSG_NOSIGNAL) == ssize_t(hello.size()) &&
                         recv(socket, &granted, 1, 0) == 1;
        close(socket);
        return did && granted == 1;
    }

    void stop() {
        if (process_ <= 0) return;
        kill(process_, SIGTERM);
        waitpid(process_, nullptr, 0);
        process_ = 0;
    }

    TemporaryDirectory directory_;
    int number_ = 0;
    pid_t process_ = 0;
};

}  // namespace farfield::test
