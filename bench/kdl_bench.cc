// The peer in the same process: KDL from Debian, on the same robot and the same inputs.
#include <benchmark/benchmark.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <kdl/velocityprofile_trap.hpp>

#include "bench/inputs.h"
#include "bench/ratio_reporter.h"

namespace sinew::bench {
namespace {

struct KdlInputs {
  KdlInputs() : in("robot-arm-2") {
    for (const DhRow& row : in.geometry.rows) {
      chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ),
                                    KDL::Frame::DH(row.a, row.alpha, row.d, row.theta_offset)));
    }
    KDL::ChainFkSolverPos_recursive solver(chain);
    for (std::size_t i = 0; i < kInputs; ++i) {
      q.push_back(array(in.q[i]));
      near.push_back(array(in.near[i]));
      far.push_back(array(in.far[i]));
      KDL::Frame frame;
      solver.JntToCart(q.back(), frame);
      frames.push_back(frame);
    }
  }

  static KDL::JntArray array(const JointVector& joints) {
    KDL::JntArray values(static_cast<unsigned>(joints.size()));
    for (std::size_t i = 0; i < joints.size(); ++i) values(static_cast<unsigned>(i)) = joints[i];
    return values;
  }

  SerialInputs in;
  KDL::Chain chain;
  std::vector<KDL::JntArray> q, near, far;
  std::vector<KDL::Frame> frames;
};

void forward(benchmark::State& state) {
  const KdlInputs in;
  KDL::ChainFkSolverPos_recursive solver(in.chain);
  KDL::Frame frame;
  std::size_t i = 0;
  for (auto _ : state) {
    solver.JntToCart(in.q[i++ % kInputs], frame);
    benchmark::DoNotOptimize(frame);
  }
}
BENCHMARK(forward)->Name(kYardstick);

void jacobian(benchmark::State& state) {
  const KdlInputs in;
  KDL::ChainJntToJacSolver solver(in.chain);
  KDL::Jacobian J(6);
  std::size_t i = 0;
  for (auto _ : state) {
    solver.JntToJac(in.q[i++ % kInputs], J);
    benchmark::DoNotOptimize(J);
  }
}
BENCHMARK(jacobian)->Name("kdl/jacobian_6r");

void inverse_lma(benchmark::State& state, const KdlInputs& in,
                 const std::vector<KDL::JntArray>& start) {
  // KDL's default weights call answers solved that are 1e-5 rad off; these ask for the same
  // accuracy that the own solver gives.
  Eigen::Matrix<double, 6, 1> weights = Eigen::Matrix<double, 6, 1>::Ones();
  KDL::ChainIkSolverPos_LMA solver(in.chain, weights, 1e-10, 500, 1e-15);
  KDL::JntArray answer(6);
  std::size_t i = 0;
  std::size_t solved = 0;
  for (auto _ : state) {
    const std::size_t now = i++ % kInputs;
    solved += solver.CartToJnt(start[now], in.frames[now], answer) >= 0;
  }
  state.counters["solved"] = static_cast<double>(solved) / static_cast<double>(i);
}
void inverse_lma_near(benchmark::State& state) {
  const KdlInputs in;
  inverse_lma(state, in, in.near);
}
void inverse_lma_far(benchmark::State& state) {
  const KdlInputs in;
  inverse_lma(state, in, in.far);
}
BENCHMARK(inverse_lma_near)->Name("kdl/inverse_lma_near");
BENCHMARK(inverse_lma_far)->Name("kdl/inverse_lma_far");

void trapezoid(benchmark::State& state) {
  const KdlInputs in;
  KDL::VelocityProfile_Trap profile(1.7, 3.5);
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t now = i++ % kInputs;
    double duration = 0;
    for (unsigned axis = 0; axis < 6; ++axis) {
      profile.SetProfile(in.q[now](axis), in.far[now](axis));
      duration = std::max(duration, profile.Duration());
    }
    for (unsigned axis = 0; axis < 6; ++axis) {
      profile.SetProfileDuration(in.q[now](axis), in.far[now](axis), duration);
      benchmark::DoNotOptimize(profile);
    }
  }
}
BENCHMARK(trapezoid)->Name("kdl/trapezoid_6_axes");

}  // namespace
}  // namespace sinew::bench
