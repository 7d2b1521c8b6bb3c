// A machine of its own for a test: a network namespace with nothing but its loopback interface, and cables
// between two. Needs root and iproute2.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "common/io/file_descriptor.h"

namespace dadrl {

inline bool MayMakeNamespaces() { return geteuid() == 0; }

// `ip ARGUMENTS`; a failure is the test's.
inline void Ip(const std::string& arguments) {
  EXPECT_EQ(std::system(("ip " + arguments).c_str()), 0) << "ip " << arguments;
}

// Gone with the object, whatever is left in it.
class NetworkNamespace {
 public:
  // `name` is one letter: a device cannot bear a long name.
  explicit NetworkNamespace(char name) : letter_(name), name_(fmt::format("dadrl-{}-{}", getpid(), name)) {
    Ip("netns add " + name_);
    Ip(fmt::format("-n {} link set lo up", name_));
  }
  ~NetworkNamespace() { Ip("netns del " + name_); }
  NetworkNamespace(const NetworkNamespace&) = delete;
  NetworkNamespace& operator=(const NetworkNamespace&) = delete;

  const std::string& name() const { return name_; }
  // Its end of the cable.
  std::string device() const { return fmt::format("v{}{}", getpid(), letter_); }

  // Calls `function` on a thread inside: the sockets that it makes are there for good.
  void Run(const std::function<void()>& function) const {
    std::thread([&] {
      const auto place = FileDescriptor::Open("/run/netns/" + name_, O_RDONLY);
      ASSERT_TRUE(place) << place.error().message;
      ASSERT_EQ(setns(place->get(), CLONE_NEWNET), 0);
      function();
    }).join();
  }

 private:
  char letter_;
  std::string name_;
};

// A cable between two machines; the addresses are in one network of 24 bits.
inline void Connect(const NetworkNamespace& a, const std::string& address_a, const NetworkNamespace& b,
                    const std::string& address_b) {
  Ip(fmt::format("link add {} netns {} type veth peer name {} netns {}", a.device(), a.name(), b.device(),
                 b.name()));
  for (const auto& [machine, address] : {std::pair(&a, &address_a), std::pair(&b, &address_b)}) {
    Ip(fmt::format("-n {} addr add {}/24 dev {}", machine->name(), *address, machine->device()));
    Ip(fmt::format("-n {} link set {} up", machine->name(), machine->device()));
  }
}

}  // namespace dadrl
