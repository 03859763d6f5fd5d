/// Who runs now: the plugin that a thread is in, for those who must name it when it never returns.
#pragma once

#include <string>

namespace deform {

/// A call into a plugin while it lasts. Costs two stores: a step makes thousands.
class PluginCall {
 public:
  /// Both texts must outlive it.
  PluginCall(const std::string& origin, const char* doing)
      : origin_(origin.c_str()), doing_(doing), outer_(innermost_) {
    innermost_ = this;
  }
  ~PluginCall() { innermost_ = outer_; }
  PluginCall(const PluginCall&) = delete;
  PluginCall& operator=(const PluginCall&) = delete;

  [[nodiscard]] const char* origin() const { return origin_; }
  [[nodiscard]] const char* doing() const { return doing_; }

  /// Of this thread; null outside of plugins. A plugin that calls the framework is still in.
  [[nodiscard]] static const PluginCall* innermost() { return innermost_; }
  /// Where this thread keeps it, for other threads that have none.
  [[nodiscard]] static const PluginCall* const* place() { return &innermost_; }

 private:
  // The framework is there from the start: its threads' variables need no look-up.
  [[gnu::tls_model("initial-exec")]] static constinit thread_local const PluginCall* innermost_;

  const char* origin_;
  const char* doing_;
  const PluginCall* outer_;
};

}  // namespace deform
