#include "core/linear/bricks/multigrid_kernel_body.h"
