// Gives every actor the number it wants, as a replay that knows no others would.
#pragma once

#include <array>
#include <memory>

#include "common/port/port.h"
#include "proto/topics.h"

namespace dadrl {

// Not thread safe.
class LeaseClerk {
 public:
  explicit LeaseClerk(const Transport& transport) {
    for (uint32_t group = 0; group < kAcknowledgementGroups; ++group) {
      answers_[group] =
          Writer<dadrl_idl_LeaseAnswer>::Create(transport, LeaseAnswerTopic({.low = group})).value();
    }
    requests_ = Reader<dadrl_idl_LeaseRequest>::Create(transport, kLeaseRequestTopic).value();
  }
  void Serve() {
    requests_->Take(16, [this](const dadrl_idl_LeaseRequest& request) {
      if (request.incarnation != 0) return;  // shows what it has
      dadrl_idl_LeaseAnswer answer{};
      answer.token_high = request.token_high;
      answer.token_low = request.token_low;
      answer.protocol = request.protocol;
      answer.schema = request.schema;
      answer.start = answer.incarnation = request.start;
      answer.number = request.number < 0 ? 0 : static_cast<uint32_t>(request.number);
      static_cast<void>(answers_[request.token_low % kAcknowledgementGroups]->Write(answer));
    });
  }

 private:
  std::array<std::unique_ptr<Writer<dadrl_idl_LeaseAnswer>>, kAcknowledgementGroups> answers_;
  std::unique_ptr<Reader<dadrl_idl_LeaseRequest>> requests_;
};

}  // namespace dadrl
