// A stub: the test creates the class itself.
#pragma once
#define PLUGINLIB_EXPORT_CLASS(Class, Base) static_assert(sizeof(static_cast<Base *>(static_cast<Class *>(nullptr))) > 0, "");
