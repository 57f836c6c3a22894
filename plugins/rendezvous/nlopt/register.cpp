#include "nlopt_rendezvous.h"
#include "vir/roles/rendezvous_registry.h"

namespace vir {
VIR_REGISTER_RENDEZVOUS(NloptRendezvous, "nlopt",
                        "yaw and offset from mutual ranges, with or without a common anchor");
}  // namespace vir
