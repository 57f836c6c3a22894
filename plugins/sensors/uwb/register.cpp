#include "uwb_serial.h"
#include "vir/roles/sensor_registry.h"

namespace vir {

VIR_REGISTER_SENSOR(UwbSerial, "uwb",
                    "UWB ranges live: DWM1001, TREK1000, AT boards, QM33, LinkTrack, ...");

}  // namespace vir
