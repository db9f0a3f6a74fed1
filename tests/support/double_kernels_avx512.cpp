#include "tests/support/double_kernels_body.h"
