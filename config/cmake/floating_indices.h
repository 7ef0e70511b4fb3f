// Lets floating-point numbers index matrices of Eigen 3.4 as those of 3.3 did: there they convert to
// Index, here they would reach the overloads for ranges. users_packages.cmake includes it first.
#pragma once

#if __has_include(<Eigen/Core>)
#include <Eigen/Core>

#if EIGEN_VERSION_AT_LEAST(3, 3, 90) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)
namespace Eigen {
namespace internal {
template <> struct is_valid_index_type<float> { enum { value = 1 }; };
template <> struct is_valid_index_type<double> { enum { value = 1 }; };
}  // namespace internal
}  // namespace Eigen
#endif
#endif
