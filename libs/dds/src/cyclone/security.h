#pragma once
#include <string>

#include "cyclone/dds_entities.h"

namespace vir::dds {

/// DDS Security with the files of an enclave of ROS 2: identity_ca.cert.pem, cert.pem, key.pem,
/// permissions_ca.cert.pem, governance.p7s, permissions.p7s. Throws std::runtime_error naming the
/// one that is missing.
void secure(dds_qos_t* participant, const std::string& folder);

}  // namespace vir::dds
