#include "core/multigrid_kernel_body.h"
