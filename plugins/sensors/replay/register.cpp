#include "rawlog_replay.h"
#include "vir/roles/sensor_registry.h"

namespace vir {

VIR_REGISTER_SENSOR(RawlogReplay, "replay", "a rawlog that comes in as if live");

}  // namespace vir
