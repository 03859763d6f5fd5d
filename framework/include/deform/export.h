/// Symbol visibility. Plugins are compiled with hidden symbols; what carries DEFORM_API is visible
/// to all: the framework's classes (their type information must be one) and a plugin's descriptor.
#pragma once

#define DEFORM_API __attribute__((visibility("default")))
