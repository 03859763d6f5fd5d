/// Symbol visibility: everything is hidden but what carries DEFORM_API (framework) or is a plugin's descriptor.
#pragma once

#define DEFORM_API __attribute__((visibility("default")))
