#pragma once
#include <memory>

#include "vir/dds/link.h"

namespace vir::dds {

/// Throws as OpenLink.
std::unique_ptr<Link> openCycloneLink(const LinkOptions& options, const LogSink& log = {});

}  // namespace vir::dds
