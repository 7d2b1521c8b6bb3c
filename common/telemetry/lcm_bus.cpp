#include "common/telemetry/lcm_bus.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "common/telemetry/multicast_probe.h"

namespace dadrl {
namespace {

void Dispatch(const lcm_recv_buf_t* packet, const char*, void* handler) {
  (*static_cast<LcmBus::Handler*>(handler))({static_cast<const std::byte*>(packet->data), packet->data_size});
}

// LCM opens also where nothing that it sends is heard.
Status CheckMulticast(std::string_view url) {
  constexpr std::string_view kMulticast = "udpm://";
  if (!url.starts_with(kMulticast)) return {};
  url.remove_prefix(kMulticast.size());
  return HearOwnMulticast(std::string(url.substr(0, url.find(':'))));
}

}  // namespace

Result<std::unique_ptr<LcmBus>> LcmBus::Open(const std::string& url) {
  const Status heard = CheckMulticast(url);
  lcm_t* lcm = heard ? lcm_create(url.c_str()) : nullptr;
  if (lcm == nullptr) {
    return Fail(
        ErrorCode::kUnavailable,
        "no LCM at {}: this host does not hear its own multicast ({}); as root: ip link set lo multicast "
        "on && ip route add 224.0.0.0/4 dev lo",
        url, heard ? "LCM refuses" : heard.error().message);
  }
  return std::unique_ptr<LcmBus>(new LcmBus(lcm));
}

LcmBus::~LcmBus() { lcm_destroy(lcm_); }

Status LcmBus::Publish(const std::string& channel, std::span<const std::byte> packet) {
  if (lcm_publish(lcm_, channel.c_str(), packet.data(), static_cast<unsigned>(packet.size())) == 0) return {};
  return Fail(ErrorCode::kUnavailable, "LCM packet on {} was refused by the system", channel);
}

Status LcmBus::Subscribe(const std::string& channel, int queue, Handler handler) {
  handlers_.push_back(std::make_unique<Handler>(std::move(handler)));
  lcm_subscription_t* subscription = lcm_subscribe(lcm_, channel.c_str(), &Dispatch, handlers_.back().get());
  if (subscription == nullptr) {
    return Fail(ErrorCode::kUnavailable, "LCM channel {}: this host does not deliver multicast to itself",
                channel);
  }
  lcm_subscription_set_queue_capacity(subscription, queue);
  return {};
}

bool LcmBus::Handle(Duration timeout) {
  const auto whole = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  return lcm_handle_timeout(lcm_, static_cast<int>(std::clamp<int64_t>(whole, 0, 3'600'000))) > 0;
}

}  // namespace dadrl
