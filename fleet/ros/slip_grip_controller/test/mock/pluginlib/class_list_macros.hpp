// Not pluginlib: what the example needs of it, so that it runs without ROS 2. The real macro registers the class for a loader.
#pragma once
#include <memory>
#define PLUGINLIB_EXPORT_CLASS(type, base) \
  std::unique_ptr<base> make_plugin() { return std::make_unique<type>(); }
