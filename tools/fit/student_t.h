// Student's t distribution: how far an estimate from few data may be off.
#pragma once

namespace umax {

/// P(T <= t) with the given degrees of freedom >= 1.
double student_t_probability(double t, int degrees_of_freedom);

/// The t with P(T <= t) = probability in (0, 1): 2.228 for 0.975 and 10.
double student_t_quantile(double probability, int degrees_of_freedom);

}  // namespace umax
