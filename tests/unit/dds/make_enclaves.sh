#!/bin/bash
# Makes what Dds.security needs, with the layout of a ROS 2 enclave: a folder for each robot, all of one authority.
#   make_enclaves.sh FOLDER ROBOT...
set -euo pipefail
mkdir -p "$1" && cd "$1"
shift
{
  openssl ecparam -name prime256v1 -genkey -noout -out ca.key.pem
  openssl req -x509 -new -key ca.key.pem -days 3650 -subj "/CN=authority of the team" -out ca.cert.pem
  cat >governance.xml <<'XML'
<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains>
        <id_range>
          <min>0</min>
          <max>230</max>
        </id_range>
      </domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
XML
  openssl smime -sign -in governance.xml -text -out governance.p7s -signer ca.cert.pem -inkey ca.key.pem
  for robot in "$@"; do
    mkdir -p "$robot"
    openssl ecparam -name prime256v1 -genkey -noout -out "$robot/key.pem"
    openssl req -new -key "$robot/key.pem" -subj "/CN=$robot" -out "$robot/request.pem"
    openssl x509 -req -in "$robot/request.pem" -CA ca.cert.pem -CAkey ca.key.pem -CAcreateserial -days 3650 \
      -out "$robot/cert.pem"
    cat >"$robot/permissions.xml" <<XML
<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="$robot">
      <subject_name>CN=$robot</subject_name>
      <validity>
        <not_before>2020-01-01T00:00:00</not_before>
        <not_after>2036-01-01T00:00:00</not_after>
      </validity>
      <allow_rule>
        <domains>
          <id_range>
            <min>0</min>
            <max>230</max>
          </id_range>
        </domains>
        <publish>
          <topics>
            <topic>*</topic>
          </topics>
          <partitions>
            <partition>*</partition>
          </partitions>
        </publish>
        <subscribe>
          <topics>
            <topic>*</topic>
          </topics>
          <partitions>
            <partition>*</partition>
          </partitions>
        </subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
XML
    openssl smime -sign -in "$robot/permissions.xml" -text -out "$robot/permissions.p7s" -signer ca.cert.pem \
      -inkey ca.key.pem
    cp ca.cert.pem "$robot/identity_ca.cert.pem"
    cp ca.cert.pem "$robot/permissions_ca.cert.pem"
    cp governance.p7s "$robot/"
  done
} 2>openssl.log || { cat openssl.log >&2; exit 1; }
