#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "vir/tables/layout.h"

namespace vir::tables {
namespace {

using Columns = std::vector<int>;
constexpr double kDeg = 0.017453292519943295;

PoseColumns poses(const std::string& text) { return poseColumns(layoutOfText(text)); }
Columns quatOf(const PoseColumns& c) { return {c.q[0], c.q[1], c.q[2], c.q[3]}; }
Columns anglesOf(const PoseColumns& c) { return {c.angles[0], c.angles[1], c.angles[2]}; }

TEST(Attitudes, QuaternionsUnderOtherNames) {
  for (const char* names :
       {"q_x,q_y,q_z,q_w", "quat.x,quat.y,quat.z,quat.w",
        "orientation.x,orientation.y,orientation.z,orientation.w", "rot_x,rot_y,rot_z,rot_w",
        "Quat_X,Quat_Y,Quat_Z,Quat_W", "att_qx,att_qy,att_qz,att_qw"}) {
    const PoseColumns c = poses("t,x,y,z," + std::string(names) + "\n1,2,3,4,0,0,0,1\n");
    EXPECT_EQ(quatOf(c), (Columns{4, 5, 6, 7})) << names;
    EXPECT_EQ(c.remark, "") << names;
  }
}

TEST(Attitudes, AnglesInAnyOrder) {
  const PoseColumns c = poses("t,yaw_deg,x,y,z,pitch_deg,roll_deg\n1,10,0,0,0,20,30\n");
  EXPECT_EQ(anglesOf(c), (Columns{6, 5, 1}));
  EXPECT_DOUBLE_EQ(c.angle_unit, kDeg);
  EXPECT_NE(c.remark.find("degrees"), std::string::npos) << c.remark;
  EXPECT_EQ(c.last(), 6);
  EXPECT_EQ(anglesOf(poses("t,x,y,z,r,p,y\n1,0,0,0,0.1,0.2,0.3\n")), (Columns{4, 5, 6}));
  const PoseColumns greek = poses("t,x,y,z,phi [rad],theta [rad],psi [rad]\n1,0,0,0,.1,.2,.3\n");
  EXPECT_EQ(anglesOf(greek), (Columns{4, 5, 6}));
  EXPECT_DOUBLE_EQ(greek.angle_unit, 1);
}

TEST(Attitudes, AnglesWithoutUnitBySize) {
  const PoseColumns deg = poses("t,x,y,z,roll,pitch,yaw\n1,0,0,0,0,0,3\n2,0,0,0,0,0,-170\n");
  EXPECT_DOUBLE_EQ(deg.angle_unit, kDeg);
  EXPECT_NE(deg.remark.find("degrees by the size"), std::string::npos) << deg.remark;
  EXPECT_DOUBLE_EQ(poses("t,x,y,z,roll,pitch,yaw\n1,0,0,0,0,0,3\n").angle_unit, 1);
  Layout later = layoutOfText("t,x,y,z,roll,pitch,yaw\n1,0,0,0,0,0,3\n");
  later.later.push_back({"9", "0", "0", "0", "0", "0", "90"});
  EXPECT_DOUBLE_EQ(poseColumns(later).angle_unit, kDeg);
  // What contradicts itself is no attitude.
  const PoseColumns no = poses("t,x,y,z,roll_rad,pitch_rad,yaw_rad\n1,0,0,0,0,0,-170\n");
  EXPECT_FALSE(no.hasAttitude());
  EXPECT_NE(no.remark.find("radians"), std::string::npos) << no.remark;
}

TEST(Attitudes, WhatCannotBeToldIsNamed) {
  for (const char* names : {"heading", "rot_x,rot_y,rot_z", "rx,ry,rz", "yaw_deg",
                            "euler_x,euler_y,euler_z", "qx,qy,qz", "r11,r12,r13"}) {
    const PoseColumns c = poses("t,x,y,z," + std::string(names) + "\n1,2,3,4,5,6,7\n");
    EXPECT_TRUE(c.named) << names;
    EXPECT_FALSE(c.hasAttitude()) << names;
    const std::string all(names);
    EXPECT_NE(c.remark.find(all.substr(0, all.find(','))), std::string::npos) << c.remark;
  }
  EXPECT_EQ(poses("t,x,y,z,vx,vy,vz,yaw_rate,temp\n1,2,3,4,5,6,7,8,9\n").remark, "");
  EXPECT_EQ(poses("#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n1,2,3,4\n").remark,
            "");
}

TEST(Attitudes, QuaternionsThatAreAllZeroAreNone) {
  for (const char* text : {"t,x,y,z,qx,qy,qz,qw\n1,2,3,4,0,0,0,0\n2,2,3,4,0,0,0.0,0\n",
                           "1 2 3 4 0 0 0 0\n2 2 3 4 0 0 0 0\n"}) {
    const PoseColumns c = poses(text);
    EXPECT_FALSE(c.hasAttitude()) << text;
    EXPECT_NE(c.remark.find("0 0 0 0"), std::string::npos) << c.remark;
  }
  EXPECT_TRUE(poses("1 2 3 4 0 0 0 0\n2 2 3 4 0 0 0 1\n").hasAttitude());
}

TEST(Attitudes, OfAnglesAreYawPitchRoll) {
  // A quarter to the left, then nose down by 90 degrees: x of the body points down, z forward
  // along the world's y.
  const double angles[3] = {0, 90 * kDeg, 90 * kDeg};
  double q[4];
  quaternionOf(angles, q);
  EXPECT_NEAR(q[0], -0.5, 1e-12);
  EXPECT_NEAR(q[1], 0.5, 1e-12);
  EXPECT_NEAR(q[2], 0.5, 1e-12);
  EXPECT_NEAR(q[3], 0.5, 1e-12);
}

}  // namespace
}  // namespace vir::tables
