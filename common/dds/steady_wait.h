// Waits of Cyclone's threads that do not depend on the wall clock.
#pragma once

namespace dadrl::dds {

// Cyclone waits until a time of the wall clock (pthread_cond_timedwait). If that clock is set back meanwhile,
// the wait takes as much longer, and with it whatever that thread should send: peers take the process for
// dead. A program that calls this waits by the monotonic clock instead, in every library it uses. To be
// called once, before a domain is made; not under sanitizers, which have a definition of their own.
void WaitSteadily();

}  // namespace dadrl::dds
