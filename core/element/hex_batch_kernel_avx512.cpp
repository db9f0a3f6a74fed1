#include "core/element/hex_batch_kernel_body.h"
