#include "core/linear/direct/front_kernel_body.h"
